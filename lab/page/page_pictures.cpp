#include "lab/page/page_pictures.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "lab/metrics/flip.h"
#include "scenes/images/image_codecs.h"

namespace sideray::lab {
namespace {

// Base64 takes four thirds of it: the page stays below 10 MB with the chart library and the figures.
constexpr size_t most_bytes_of_all = size_t{6} << 20;
constexpr double bytes_per_pixel = 0.4;  // of the JPEG of a rendered picture, generously

std::string base64(std::span<const uint8_t> bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t count = std::min<size_t>(3, bytes.size() - i);
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < count ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) text.push_back(k <= count ? digits[bits >> (18 - 6 * k) & 63] : '=');
  }
  return text;
}

// Shrinks a picture by averaging the whole pixels that each new pixel covers.
std::vector<float> shrink(std::span<const float> values, uint32_t width, uint32_t height, size_t channels,
                          const PageScale& scale) {
  if (scale.width == width && scale.height == height) return {values.begin(), values.end()};
  std::vector<float> small;
  small.reserve(size_t{scale.width} * scale.height * channels);
  const auto from = [](uint64_t i, uint64_t whole, uint64_t parts) { return i * whole / parts; };
  for (uint32_t y = 0; y < scale.height; ++y)
    for (uint32_t x = 0; x < scale.width; ++x) {
      const uint64_t y0 = from(y, height, scale.height), y1 = from(y + 1u, height, scale.height);
      const uint64_t x0 = from(x, width, scale.width), x1 = from(x + 1u, width, scale.width);
      for (size_t c = 0; c < channels; ++c) {
        double sum = 0;
        for (uint64_t v = y0; v < y1; ++v)
          for (uint64_t u = x0; u < x1; ++u) sum += double{values[(v * width + u) * channels + c]};
        small.push_back(static_cast<float>(sum / static_cast<double>((y1 - y0) * (x1 - x0))));
      }
    }
  return small;
}

std::string data_uri(std::span<const uint8_t> rgb, const PageScale& scale) {
  const std::string what = "a picture of the page";
  if (scale.is_exact)
    return "data:image/png;base64," + base64(scenes::encode_png(scale.width, scale.height, 3, rgb, what));
  std::vector<uint8_t> bytes;
  for (int quality : {90, 75, 50, 25}) {
    bytes = scenes::encode_jpeg(scale.width, scale.height, rgb, quality, what);
    if (bytes.size() <= scale.most_bytes) break;
  }
  return "data:image/jpeg;base64," + base64(bytes);
}

std::string picture_of(const std::vector<float>& values, const scenes::Image& image, const PageScale& scale) {
  return data_uri(scenes::quantize(shrink(values, image.width, image.height, 3, scale)), scale);
}

bool is_finite(const scenes::Image& image) {
  for (const char* name : {"R", "G", "B"}) {
    const scenes::Plane* plane = image.find(name);
    if (plane == nullptr) return false;
    if (!std::all_of(plane->values.begin(), plane->values.end(), [](float v) { return std::isfinite(v); }))
      return false;
  }
  return true;
}

}  // namespace

PageScale page_scale(uint32_t width, uint32_t height, size_t pictures) {
  PageScale scale{width, height, most_bytes_of_all / std::max<size_t>(pictures, 1), false};
  const double pixels = static_cast<double>(width) * height;
  scale.is_exact = pixels * 3 <= static_cast<double>(scale.most_bytes);
  const double factor = std::sqrt(static_cast<double>(scale.most_bytes) / bytes_per_pixel / pixels);
  if (scale.is_exact || factor >= 1) return scale;
  const auto side = [&](uint32_t whole) {
    return std::clamp(static_cast<uint32_t>(std::lround(whole * factor)), 1u, whole);
  };
  scale.width = side(width);
  scale.height = side(height);
  return scale;
}

std::string page_picture(const scenes::Image& image, const Display& display, const PageScale& scale) {
  return picture_of(scenes::display_values(image, display.exposure_ev, display.tonemap), image, scale);
}

std::string png_uri(const std::vector<uint8_t>& rgb, uint32_t width, uint32_t height) {
  return data_uri(rgb, {width, height, 0, true});
}

std::string page_map(const std::vector<uint8_t>& rgb, uint32_t width, uint32_t height, const PageScale& scale) {
  std::vector<float> values(rgb.size());
  std::transform(rgb.begin(), rgb.end(), values.begin(), [](uint8_t v) { return static_cast<float>(v) / 255.0f; });
  return data_uri(scenes::quantize(shrink(values, width, height, 3, scale)), scale);
}

PagePicture page_picture(const scenes::Image& image, const scenes::Image& reference, const Display& display,
                         const PageScale& scale) {
  const std::vector<float> test = scenes::display_values(image, display.exposure_ev, display.tonemap);
  PagePicture page{picture_of(test, image, scale), {}};
  if (!is_finite(image) || !is_finite(reference)) return page;
  const std::vector<float> truth = scenes::display_values(reference, display.exposure_ev, display.tonemap);
  const FlipMap flip = ldr_flip(test, truth, image.width, image.height);
  page.map = data_uri(false_colours(shrink(flip.error, image.width, image.height, 1, scale)), scale);
  return page;
}

}  // namespace sideray::lab
