#include "lab/metrics/metrics.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <sideray/sideray.hpp>

#include "lab/metrics/flip.h"
#include "lab/metrics/parallel.h"

namespace sideray::lab {
namespace {

using scenes::Image;

double linear_from_srgb(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// Returns R, G, B interleaved as stored.
std::vector<float> stored_rgb(const Image& image, const char* which) {
  std::vector<float> rgb(size_t{image.width} * image.height * 3);
  const std::array<const char*, 3> names{"R", "G", "B"};
  for (size_t k = 0; k < 3; ++k) {
    const scenes::Plane* plane = image.find(names[k]);
    if (!plane || plane->values.size() * 3 != rgb.size())
      throw Error(SIDERAY_INVALID_ARGUMENT,
                  fmt::format("{}: has no channel {}; compare images with R, G and B", which, names[k]));
    for (size_t i = 0; i < plane->values.size(); ++i) rgb[3 * i + k] = plane->values[i];
  }
  return rgb;
}

std::vector<float> linear_rgb(const Image& image, std::vector<float> rgb) {
  if (!image.linear)
    for (float& v : rgb) v = static_cast<float>(linear_from_srgb(static_cast<double>(v)));
  return rgb;
}

uint64_t nonfinite_pixels(const std::vector<float>& a, const std::vector<float>& b) {
  uint64_t count = 0;
  for (size_t i = 0; i < a.size(); i += 3) {
    bool finite = true;
    for (size_t k = i; k < i + 3; ++k) finite = finite && std::isfinite(a[k]) && std::isfinite(b[k]);
    count += !finite;
  }
  return count;
}

void set_relmse(Metrics& metrics, const std::vector<float>& test, const std::vector<float>& reference) {
  std::vector<double> terms(test.size());
  for (size_t i = 0; i < terms.size(); ++i) {
    const double x = static_cast<double>(test[i]), r = static_cast<double>(reference[i]);
    terms[i] = (x - r) * (x - r) / (r * r + 0.01);
  }
  metrics.relmse = std::accumulate(terms.begin(), terms.end(), 0.0) / static_cast<double>(terms.size());
  // The terms are sorted, not partitioned, so that the order of additions does not depend on the standard library.
  std::sort(terms.begin(), terms.end());
  const size_t kept = terms.size() - terms.size() / 1000;
  metrics.relmse_trimmed = std::accumulate(terms.begin(), terms.begin() + static_cast<std::ptrdiff_t>(kept), 0.0) /
                           static_cast<double>(kept);
}

double psnr(const std::vector<float>& test, const std::vector<float>& reference) {
  double squares = 0;
  for (size_t i = 0; i < test.size(); ++i) {
    const double d = static_cast<double>(test[i]) - static_cast<double>(reference[i]);
    squares += d * d;
  }
  if (squares == 0) return 999.0;
  return std::min(999.0, -10.0 * std::log10(squares / static_cast<double>(test.size())));
}

constexpr size_t ssim_window = 11;

std::array<double, ssim_window> ssim_weights() {
  std::array<double, ssim_window> weights{};
  for (size_t i = 0; i < ssim_window; ++i) {
    const double x = static_cast<double>(i) - 5.0;
    weights[i] = std::exp(-x * x / (2.0 * 1.5 * 1.5));
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& w : weights) w /= sum;
  return weights;
}

double luma(const std::vector<float>& rgb, size_t i) {
  return 0.2126 * static_cast<double>(rgb[3 * i]) + 0.7152 * static_cast<double>(rgb[3 * i + 1]) +
         0.0722 * static_cast<double>(rgb[3 * i + 2]);
}

// Holds the weighted moments of one window: mean and mean square of x and y, mean product.
struct Moments {
  double x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  void add(double w, const Moments& m) { x += w * m.x, y += w * m.y, xx += w * m.xx, yy += w * m.yy, xy += w * m.xy; }
};

double ssim_of(const Moments& m) {
  constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
  const double var_x = m.xx - m.x * m.x, var_y = m.yy - m.y * m.y, covariance = m.xy - m.x * m.y;
  return (2 * m.x * m.y + c1) * (2 * covariance + c2) / ((m.x * m.x + m.y * m.y + c1) * (var_x + var_y + c2));
}

// Returns the mean over the windows wholly inside. Each row of windows has its own sum, so that the order of additions
// is fixed.
double ssim(const std::vector<float>& test, const std::vector<float>& reference, uint32_t width, uint32_t height) {
  const std::array<double, ssim_window> weights = ssim_weights();
  constexpr auto window_px = static_cast<uint32_t>(ssim_window);
  const uint32_t across = width - window_px + 1, down = height - window_px + 1;
  std::vector<double> row_sums(down);
  for_rows(down, [&](uint32_t top) {
    std::vector<Moments> columns(width);
    for (uint32_t x = 0; x < width; ++x)
      for (size_t k = 0; k < ssim_window; ++k) {
        const size_t i = (top + k) * width + x;
        const double a = luma(test, i), b = luma(reference, i);
        columns[x].add(weights[k], {a, b, a * a, b * b, a * b});
      }
    for (uint32_t left = 0; left < across; ++left) {
      Moments window;
      for (size_t k = 0; k < ssim_window; ++k) window.add(weights[k], columns[left + k]);
      row_sums[top] += ssim_of(window);
    }
  });
  return std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / (static_cast<double>(across) * down);
}

struct MetricName {
  const char* name;
  std::optional<double> Metrics::*value;
};
constexpr MetricName named_metrics[] = {{"flip", &Metrics::flip},     {"hdr_flip", &Metrics::hdr_flip},
                                        {"relmse", &Metrics::relmse}, {"relmse_trimmed", &Metrics::relmse_trimmed},
                                        {"psnr", &Metrics::psnr},     {"ssim", &Metrics::ssim}};

}  // namespace

Comparison compare(const Image& test, const Image& reference, const Display& display) {
  if (test.width != reference.width || test.height != reference.height)
    throw Error(SIDERAY_INVALID_ARGUMENT, fmt::format("sizes differ: {}x{} against {}x{}; compare images of one size",
                                                      test.width, test.height, reference.width, reference.height));
  std::vector<float> test_rgb = stored_rgb(test, "test"), reference_rgb = stored_rgb(reference, "reference");
  Comparison result;
  Metrics& metrics = result.metrics;
  metrics.nonfinite = nonfinite_pixels(test_rgb, reference_rgb);
  if (metrics.nonfinite != 0) return result;

  const uint32_t width = test.width, height = test.height;
  if (test.linear && reference.linear) metrics.hdr_flip = hdr_flip(test_rgb, reference_rgb, width, height).mean;
  // Radiance and display values are different quantities: their difference would mean nothing.
  if (test.linear == reference.linear)
    set_relmse(metrics, linear_rgb(test, std::move(test_rgb)), linear_rgb(reference, std::move(reference_rgb)));

  const std::vector<float> shown = scenes::display_values(test, display.exposure_ev, display.tonemap);
  const std::vector<float> wanted = scenes::display_values(reference, display.exposure_ev, display.tonemap);
  FlipMap map = ldr_flip(shown, wanted, width, height);
  metrics.flip = map.mean;
  metrics.psnr = psnr(shown, wanted);
  if (width >= ssim_window && height >= ssim_window) metrics.ssim = ssim(shown, wanted, width, height);
  result.flip_map = std::move(map.error);
  return result;
}

nlohmann::ordered_json to_json(const Metrics& metrics) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const MetricName& m : named_metrics)
    if (const std::optional<double>& value = metrics.*m.value; value && std::isfinite(*value)) json[m.name] = *value;
  json["nonfinite"] = metrics.nonfinite;
  return json;
}

std::optional<double> metric(const Metrics& metrics, const std::string& name) {
  for (const MetricName& m : named_metrics)
    if (name == m.name) return metrics.*m.value;
  throw Error(SIDERAY_INVALID_ARGUMENT,
              fmt::format("metric {}: unknown; one of {}", name, fmt::join(metric_names(), ", ")));
}

const std::vector<std::string>& metric_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const MetricName& m : named_metrics) list.emplace_back(m.name);
    return list;
  }();
  return names;
}

bool larger_is_better(const std::string& name) {
  return name == "psnr" || name == "ssim";
}

std::vector<uint8_t> false_colours(const std::vector<float>& map) {
  // Lightness rises, so that the picture can also be read in grey.
  constexpr std::array<std::array<float, 3>, 6> stops{
      {{0, 0, 4}, {59, 15, 112}, {140, 41, 129}, {222, 73, 104}, {254, 159, 109}, {252, 253, 191}}};
  std::vector<uint8_t> rgb;
  rgb.reserve(map.size() * 3);
  for (float value : map) {
    const float position = std::clamp(value, 0.0f, 1.0f) * static_cast<float>(stops.size() - 1);
    const size_t low = std::min(stops.size() - 2, static_cast<size_t>(position));
    const float part = position - static_cast<float>(low);
    for (size_t k = 0; k < 3; ++k)
      rgb.push_back(static_cast<uint8_t>(std::lround(stops[low][k] + part * (stops[low + 1][k] - stops[low][k]))));
  }
  return rgb;
}

}  // namespace sideray::lab
