#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "elementary/functions.h"
#include "scenes/base/files.h"
#include "scenes/images/images.h"

namespace sideray::scenes {
namespace {

using Color = std::array<double, 3>;

// IEC 61966-2-1.
double srgb_oetf(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * elementary::pow(linear, 1.0 / 2.4) - 0.055;
}

double reinhard(double x) {
  return x / (1.0 + x);
}

// K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2016: a fit of the ACES reference and output transforms.
double aces(double x) {
  return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

// ACESFilmicToneMapping of three.js: S. Hill's fit of the ACES reference and output transforms, of the radiance divided
// by 0.6. Bright colours become grey.
Color aces_filmic(Color color) {
  using Rows = std::array<Color, 3>;
  constexpr Rows into{{{0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}}};
  constexpr Rows out{{{1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}}};
  const auto times = [](const Rows& rows, const Color& c) {
    Color product{};
    for (size_t i = 0; i < 3; ++i) product[i] = rows[i][0] * c[0] + rows[i][1] * c[1] + rows[i][2] * c[2];
    return product;
  };
  for (double& c : color) c = std::min(c / 0.6, 1e6);  // above that the fit is constant; finite squares
  color = times(into, color);
  for (double& c : color) c = (c * (c + 0.0245786) - 0.000090537) / (c * (0.983729 * c + 0.4329510) + 0.238081);
  return times(out, color);
}

// Khronos PBR Neutral Tone Mapper, specification 1.0.
Color pbr_neutral(Color color) {
  constexpr double start_compression = 0.8 - 0.04, desaturation = 0.15;
  const double lowest = std::min({color[0], color[1], color[2]});
  const double offset = lowest < 0.08 ? lowest - 6.25 * lowest * lowest : 0.04;
  for (double& c : color) c -= offset;
  const double peak = std::max({color[0], color[1], color[2]});
  if (peak < start_compression) return color;
  constexpr double range = 1.0 - start_compression;
  const double new_peak = 1.0 - range * range / (peak + range - start_compression);
  const double grey = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
  for (double& c : color) c = (1.0 - grey) * (c * new_peak / peak) + grey * new_peak;
  return color;
}

Color mapped(Color color, Tonemap tonemap) {
  switch (tonemap) {
    case Tonemap::none:
      break;
    case Tonemap::reinhard:
      for (double& c : color) c = reinhard(c);
      break;
    case Tonemap::aces:
      for (double& c : color) c = aces(c);
      break;
    case Tonemap::aces_filmic:
      return aces_filmic(color);
    case Tonemap::pbr_neutral:
      return pbr_neutral(color);
  }
  return color;
}

std::array<const Plane*, 3> color_planes(const Image& image) {
  std::array<const Plane*, 3> planes{image.find("R"), image.find("G"), image.find("B")};
  if (const Plane* luminance = image.find("Y"); luminance != nullptr && planes[0] == nullptr) {
    planes.fill(luminance);
  }
  const size_t pixels = size_t{image.width} * image.height;
  for (const Plane* plane : planes) {
    if (plane == nullptr || plane->values.size() != pixels) {
      refuse("cannot display the picture: it lacks R, G, B channels; choose a picture with colours");
    }
  }
  return planes;
}

}  // namespace

Tonemap tonemap_named(const std::string& name) {
  const auto at = std::find(std::begin(tonemap_names), std::end(tonemap_names), name);
  if (at == std::end(tonemap_names))
    refuse("tonemap: unknown value \"{}\"; one of {}", name, fmt::join(tonemap_names, ", "));
  return static_cast<Tonemap>(at - std::begin(tonemap_names));
}

std::vector<float> display_values(const Image& image, float exposure_ev, Tonemap tonemap) {
  const std::array<const Plane*, 3> planes = color_planes(image);
  const size_t pixels = size_t{image.width} * image.height;
  const double exposure = elementary::exp2(double{exposure_ev});
  std::vector<float> display(pixels * 3);
  for (size_t i = 0; i < pixels; ++i) {
    if (!image.linear) {
      for (size_t c = 0; c < 3; ++c) display[3 * i + c] = planes[c]->values[i];
      continue;
    }
    Color color{};
    for (size_t c = 0; c < 3; ++c) {
      const double value = double{planes[c]->values[i]} * exposure;
      // NaN and negative become black; the bound keeps the tone maps finite.
      color[c] = value > 0.0 ? std::min(value, 1e30) : 0.0;
    }
    color = mapped(color, tonemap);
    for (size_t c = 0; c < 3; ++c) display[3 * i + c] = static_cast<float>(srgb_oetf(std::clamp(color[c], 0.0, 1.0)));
  }
  return display;
}

std::vector<uint8_t> quantize(std::span<const float> display) {
  std::vector<uint8_t> bytes(display.size());
  std::transform(display.begin(), display.end(), bytes.begin(), [](float value) {
    return value > 0.0f ? static_cast<uint8_t>(std::floor(std::min(double{value}, 1.0) * 255.0 + 0.5)) : uint8_t{0};
  });
  return bytes;
}

}  // namespace sideray::scenes
