#include "model/texture.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "elementary/functions.h"
#include "model/failure.h"

namespace sideray::model {
namespace {

constexpr uint32_t largest_side = 16384;

struct SrgbTable {
  float linear[256];
  SrgbTable() {
    for (int i = 0; i < 256; ++i) {
      const double c = i / 255.0;
      linear[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : elementary::pow((c + 0.055) / 1.055, 2.4));
    }
  }
};

uint8_t linear_to_srgb(float x) {
  const float y = x <= 0.0031308f ? 12.92f * x : 1.055f * elementary::pow(x, 1.0f / 2.4f) - 0.055f;
  return static_cast<uint8_t>(std::clamp(y, 0.0f, 1.0f) * 255.0f + 0.5f);
}

// Holds the texels that one texel of the next mip level covers along an axis, and the weight of each.
struct Cover {
  uint32_t first, count;
  float part[3];
};

// An odd number of texels is covered by three each, the outer ones in part, so that all have the same total weight.
Cover cover_of(uint32_t x, uint32_t size) {
  if (size == 1) return {0, 1, {1.0f}};
  if (size % 2 == 0) return {2 * x, 2, {0.5f, 0.5f}};
  const auto all = static_cast<float>(size), half = static_cast<float>(size / 2), at = static_cast<float>(x);
  return {2 * x, 3, {(half - at) / all, half / all, (at + 1.0f) / all}};
}

// Makes the next mip level: each texel is the weighted mean of those it covers.
Texture::Level halve(const Texture::Level& from, bool srgb) {
  Texture::Level to{std::max(1u, from.width / 2), std::max(1u, from.height / 2), {}};
  to.rgba.resize(size_t{4} * to.width * to.height);
  const float(&table)[256] = srgb_to_linear_table();
  for (uint32_t y = 0; y < to.height; ++y) {
    const Cover rows = cover_of(y, from.height);
    for (uint32_t x = 0; x < to.width; ++x) {
      const Cover columns = cover_of(x, from.width);
      float mean[4] = {};
      for (uint32_t k = 0; k < rows.count; ++k)
        for (uint32_t i = 0; i < columns.count; ++i) {
          const float part = rows.part[k] * columns.part[i];
          const uint8_t* texel = &from.rgba[size_t{4} * (size_t{rows.first + k} * from.width + columns.first + i)];
          for (int c = 0; c < 4; ++c)
            mean[c] += part * (srgb && c < 3 ? table[texel[c]] : static_cast<float>(texel[c]));
        }
      uint8_t* out = &to.rgba[size_t{4} * (size_t{y} * to.width + x)];
      for (int c = 0; c < 4; ++c)
        out[c] = srgb && c < 3 ? linear_to_srgb(mean[c]) : static_cast<uint8_t>(mean[c] + 0.5f);
    }
  }
  return to;
}

}  // namespace

const float (&srgb_to_linear_table())[256] {
  static const SrgbTable table;
  return table.linear;
}

std::shared_ptr<const Texture> build_texture(uint32_t width, uint32_t height, sideray_texel_format format,
                                             const void* texels) {
  if (width == 0 || height == 0 || width > largest_side || height > largest_side)
    fail(SIDERAY_INVALID_ARGUMENT, "texture of {}x{}: out of range; each side must be 1 to {}", width, height,
         largest_side);
  if (!texels) fail(SIDERAY_INVALID_ARGUMENT, "texture texels: NULL; give width * height * 4 bytes");
  if (format != SIDERAY_RGBA8 && format != SIDERAY_RGBA8_SRGB)
    fail(SIDERAY_INVALID_ARGUMENT, "texture format {}: unknown; give SIDERAY_RGBA8 or SIDERAY_RGBA8_SRGB",
         static_cast<int>(format));
  auto texture = std::make_shared<Texture>();
  texture->srgb = format == SIDERAY_RGBA8_SRGB;
  Texture::Level level{width, height, {}};
  level.rgba.resize(size_t{4} * width * height);
  std::memcpy(level.rgba.data(), texels, level.rgba.size());
  for (size_t i = 0; i < level.rgba.size(); i += 4) {
    texture->minimum_green = std::min(texture->minimum_green, level.rgba[i + 1]);
    texture->minimum_alpha = std::min(texture->minimum_alpha, level.rgba[i + 3]);
  }
  texture->levels.push_back(std::move(level));
  while (texture->levels.back().width > 1 || texture->levels.back().height > 1)
    texture->levels.push_back(halve(texture->levels.back(), texture->srgb));
  return texture;
}

}  // namespace sideray::model
