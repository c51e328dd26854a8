#include "lab/metrics/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "lab/metrics/convolution.h"
#include "lab/metrics/parallel.h"

namespace sideray::lab {
namespace {

using glm::vec3;

// Rec.709 primaries with D65, as exact fractions; columns are the XYZ of red, green and blue.
const glm::dmat3 xyz_from_rgb_exact(10135552.0 / 24577794.0, 2613072.0 / 12288897.0, 1425312.0 / 73733382.0,
                                    8788810.0 / 24577794.0, 8788810.0 / 12288897.0, 8788810.0 / 73733382.0,
                                    4435075.0 / 24577794.0, 887015.0 / 12288897.0, 70074185.0 / 73733382.0);
const glm::mat3 xyz_from_rgb(xyz_from_rgb_exact);
const glm::mat3 rgb_from_xyz(glm::inverse(xyz_from_rgb_exact));
const vec3 white = xyz_from_rgb * vec3(1.0f);

float linear_from_srgb(float s) {
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

vec3 ycxcz_from_rgb(vec3 rgb) {
  const vec3 xyz = xyz_from_rgb * rgb / white;
  return {116.0f * xyz.y - 16.0f, 500.0f * (xyz.x - xyz.y), 200.0f * (xyz.y - xyz.z)};
}

vec3 rgb_from_ycxcz(vec3 c) {
  const float y = (c.x + 16.0f) / 116.0f;
  return rgb_from_xyz * (vec3(y + c.y / 500.0f, y, y - c.z / 200.0f) * white);
}

float lab_curve(float t) {
  constexpr float delta = 6.0f / 29.0f;
  return t > delta * delta * delta ? std::cbrt(t) : t / (3.0f * delta * delta) + 4.0f / 29.0f;
}

// Converts to CIELAB with the Hunt effect: chroma decreases with lightness.
vec3 hunt_lab_from_rgb(vec3 rgb) {
  const vec3 xyz = xyz_from_rgb * rgb / white;
  const float x = lab_curve(xyz.x), y = lab_curve(xyz.y), z = lab_curve(xyz.z);
  const float lightness = 116.0f * y - 16.0f;
  return {lightness, 0.01f * lightness * 500.0f * (x - y), 0.01f * lightness * 200.0f * (y - z)};
}

float hyab(vec3 a, vec3 b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

// Maps the powered colour difference to 0..1: 0.4 of the largest difference (green to blue) becomes 0.95.
float redistributed(float difference) {
  static const float largest = std::pow(hyab(hunt_lab_from_rgb(vec3(0, 1, 0)), hunt_lab_from_rgb(vec3(0, 0, 1))), 0.7f);
  const float knee = 0.4f * largest;
  if (difference < knee) return 0.95f / knee * difference;
  return std::min(1.0f, 0.95f + (difference - knee) / (largest - knee) * 0.05f);
}

Kernel normalized(std::vector<double> weights) {
  double positive = 0, negative = 0;
  for (double w : weights) (w > 0 ? positive : negative) += std::abs(w);
  Kernel kernel;
  for (double w : weights) kernel.push_back(static_cast<float>(w > 0 ? w / positive : negative > 0 ? w / negative : 0));
  return kernel;
}

// Describes one Gaussian a * sqrt(pi / b) * exp(-pi^2 d^2 / b) of a contrast sensitivity function, d in degrees.
struct Gaussian {
  double a, b;
};

struct WeightedKernel {
  Kernel kernel;  // sums to 1
  float weight;
};

std::vector<WeightedKernel> contrast_filter(const std::vector<Gaussian>& gaussians) {
  constexpr double pi = std::numbers::pi;
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * pi * pi)) * flip_pixels_per_degree));
  std::vector<WeightedKernel> filter;
  std::vector<double> weights;
  double total = 0;
  for (const Gaussian& g : gaussians) {
    std::vector<double> samples;
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) {
      const double degrees = i / flip_pixels_per_degree;
      samples.push_back(std::exp(-pi * pi * degrees * degrees / g.b));
      sum += samples.back();
    }
    weights.push_back(g.a * std::sqrt(pi / g.b) * sum * sum);
    total += weights.back();
    filter.push_back({normalized(samples), 0.0f});
  }
  for (size_t i = 0; i < filter.size(); ++i) filter[i].weight = static_cast<float>(weights[i] / total);
  return filter;
}

Plane filtered(const Plane& plane, const std::vector<WeightedKernel>& filter) {
  Plane sum(plane.width, plane.height);
  for (const WeightedKernel& part : filter) {
    const Plane smooth = convolve(plane, part.kernel, part.kernel);
    for (size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += part.weight * smooth.values[i];
  }
  return sum;
}

// Holds the Gaussian of the feature detectors and its first two derivatives, whose positive and negative parts each sum
// to 1.
struct FeatureKernels {
  Kernel smooth, edge, point;
};

FeatureKernels feature_kernels() {
  const double sigma = 0.5 * 0.082 * flip_pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> smooth, edge, point;
  for (int x = -radius; x <= radius; ++x) {
    const double g = std::exp(-x * x / (2.0 * sigma * sigma));
    smooth.push_back(g);
    edge.push_back(-x * g);
    point.push_back((x * x / (sigma * sigma) - 1.0) * g);
  }
  return {normalized(smooth), normalized(edge), normalized(point)};
}

// Holds the features of one image that FLIP compares.
struct Appearance {
  std::array<Plane, 3> smooth_ycxcz;
  Plane edge, point;  // feature magnitudes
};

Plane magnitude(const Plane& luma, const Kernel& derivative, const Kernel& smooth) {
  Plane across = convolve(luma, derivative, smooth);
  const Plane down = convolve(luma, smooth, derivative);
  for (size_t i = 0; i < across.values.size(); ++i) across.values[i] = std::hypot(across.values[i], down.values[i]);
  return across;
}

// `linear_rgb(i)` returns pixel i, 0..1.
template <typename F>
Appearance appearance(uint32_t width, uint32_t height, const F& linear_rgb) {
  static const auto achromatic = contrast_filter({{1.0, 0.0047}});
  static const auto red_green = contrast_filter({{1.0, 0.0053}});
  static const auto blue_yellow = contrast_filter({{34.1, 0.04}, {13.5, 0.025}});
  static const FeatureKernels features = feature_kernels();
  std::array<Plane, 3> ycxcz{Plane(width, height), Plane(width, height), Plane(width, height)};
  Plane luma(width, height);
  for_rows(height, [&](uint32_t y) {
    for (size_t i = size_t{y} * width; i < (size_t{y} + 1) * width; ++i) {
      const vec3 c = ycxcz_from_rgb(linear_rgb(i));
      for (int k = 0; k < 3; ++k) ycxcz[static_cast<size_t>(k)].values[i] = c[k];
      luma.values[i] = (c.x + 16.0f) / 116.0f;
    }
  });
  return {{filtered(ycxcz[0], achromatic), filtered(ycxcz[1], red_green), filtered(ycxcz[2], blue_yellow)},
          magnitude(luma, features.edge, features.smooth),
          magnitude(luma, features.point, features.smooth)};
}

vec3 perceived(const Appearance& image, size_t i) {
  const vec3 c(image.smooth_ycxcz[0].values[i], image.smooth_ycxcz[1].values[i], image.smooth_ycxcz[2].values[i]);
  return hunt_lab_from_rgb(glm::clamp(rgb_from_ycxcz(c), 0.0f, 1.0f));
}

float difference(const Appearance& test, const Appearance& reference, size_t i) {
  const float colour = redistributed(std::pow(hyab(perceived(test, i), perceived(reference, i)), 0.7f));
  const float feature = std::max(std::abs(test.edge.values[i] - reference.edge.values[i]),
                                 std::abs(test.point.values[i] - reference.point.values[i]));
  const float amplification = std::sqrt(feature * std::numbers::sqrt2_v<float> * 0.5f);
  return std::pow(colour, 1.0f - std::min(1.0f, amplification));
}

vec3 pixel(std::span<const float> rgb, size_t i) {
  return {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]};
}

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (float v : values) sum += static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

void keep_larger(FlipMap& map, const Appearance& test, const Appearance& reference) {
  const uint32_t width = test.edge.width;
  for_rows(test.edge.height, [&](uint32_t y) {
    for (size_t i = size_t{y} * width; i < (size_t{y} + 1) * width; ++i)
      map.error[i] = std::max(map.error[i], difference(test, reference, i));
  });
}

// Holds Narkowicz' fit of ACES as FLIP uses it: (k0 x^2 + k1 x) / (k2 x^2 + k3 x + k4), the 0.6 pre-exposure folded in.
template <typename T>
struct Aces {
  static constexpr T k0 = T(0.6 * 0.6 * 2.51), k1 = T(0.6 * 0.03), k2 = T(0.6 * 0.6 * 2.43), k3 = T(0.6 * 0.59),
                     k4 = T(0.14);
};

// Negative radiance (in filtered environments) passes through, as in the authors' implementation; the denominator has
// no real root.
vec3 aces(vec3 x) {
  using K = Aces<float>;
  return glm::clamp((x * (K::k0 * x + K::k1)) / (x * (K::k2 * x + K::k3) + K::k4), 0.0f, 1.0f);
}

// Returns the value that ACES maps to `t`: the positive root of the quadratic.
double aces_inverse(double t) {
  using K = Aces<double>;
  const double a = K::k0 - t * K::k2, b = K::k1 - t * K::k3, c = -t * K::k4;
  const double half = -0.5 * b / a;
  return half + std::sqrt(half * half - c / a);
}

// Returns exposures, in stops, as published with HDR-FLIP (Andersson et al. 2021, automatic start and stop exposures):
// the first shows the reference's brightest pixel at 0.85, the last its median.
std::vector<double> exposures(std::span<const float> reference) {
  std::vector<float> luminance;
  for (size_t i = 0; i < reference.size() / 3; ++i) luminance.push_back((xyz_from_rgb * pixel(reference, i)).y);
  std::sort(luminance.begin(), luminance.end());
  constexpr double smallest = 1e-6;  // keeps an all-black reference finite
  const size_t middle = luminance.size() / 2;
  const double median = 0.5 * (static_cast<double>(luminance[middle]) +
                               static_cast<double>(luminance[luminance.size() % 2 ? middle : middle - 1]));
  const double shown = aces_inverse(0.85);
  const double first = std::log2(shown / std::max(smallest, static_cast<double>(luminance.back())));
  const double last = std::log2(shown / std::max(smallest, median));
  const int count = std::max(2, static_cast<int>(std::ceil(last - first)));
  std::vector<double> stops;
  for (int i = 0; i < count; ++i) stops.push_back(first + (last - first) * i / (count - 1));
  return stops;
}

}  // namespace

FlipMap ldr_flip(std::span<const float> test, std::span<const float> reference, uint32_t width, uint32_t height) {
  FlipMap map{std::vector<float>(size_t{width} * height), 0};
  const auto look = [&](std::span<const float> rgb) {
    return appearance(width, height, [=](size_t i) {
      const vec3 c = glm::clamp(pixel(rgb, i), 0.0f, 1.0f);
      return vec3(linear_from_srgb(c.x), linear_from_srgb(c.y), linear_from_srgb(c.z));
    });
  };
  keep_larger(map, look(test), look(reference));
  map.mean = mean(map.error);
  return map;
}

FlipMap hdr_flip(std::span<const float> test, std::span<const float> reference, uint32_t width, uint32_t height) {
  FlipMap map{std::vector<float>(size_t{width} * height), 0};
  for (double stops : exposures(reference)) {
    const float scale = static_cast<float>(std::exp2(stops));
    const auto look = [&](std::span<const float> rgb) {
      return appearance(width, height, [=](size_t i) { return aces(scale * pixel(rgb, i)); });
    };
    keep_larger(map, look(test), look(reference));
  }
  map.mean = mean(map.error);
  return map;
}

}  // namespace sideray::lab
