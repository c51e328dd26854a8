#include "rt/texture_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sideray::rt {
namespace {

using Level = model::Texture::Level;

// IEC 61966-2-1, as OpenGL decodes it: before filtering, alpha untouched.
const std::array<float, 256>& srgb_decode_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (size_t i = 0; i < t.size(); ++i) {
      const double c = static_cast<double>(i) / 255.0;
      t[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
    }
    return t;
  }();
  return table;
}

struct FetchColor {
  bool srgb;
  glm::vec4 operator()(const Level& level, size_t texel) const {
    const uint8_t* p = level.rgba.data() + 4 * texel;
    constexpr float scale = 1.0f / 255.0f;
    const float alpha = static_cast<float>(p[3]) * scale;
    if (srgb) {
      const std::array<float, 256>& decode = srgb_decode_table();
      return {decode[p[0]], decode[p[1]], decode[p[2]], alpha};
    }
    return {static_cast<float>(p[0]) * scale, static_cast<float>(p[1]) * scale, static_cast<float>(p[2]) * scale,
            alpha};
  }
};

struct FetchAlpha {
  float operator()(const Level& level, size_t texel) const {
    return static_cast<float>(level.rgba[4 * texel + 3]) * (1.0f / 255.0f);
  }
};

// Into one period (two for MIRROR), so that the integers below stay small whatever the coordinate.
float reduce(float s, sideray_wrap wrap) {
  if (!std::isfinite(s)) return 0.0f;
  if (wrap == SIDERAY_CLAMP) return std::clamp(s, 0.0f, 1.0f);
  if (wrap == SIDERAY_MIRROR) return s - 2.0f * std::floor(0.5f * s);
  return s - std::floor(s);
}

// `i` is at most one texel outside the period of reduce().
size_t wrap_texel(int64_t i, int64_t size, sideray_wrap wrap) {
  if (wrap == SIDERAY_CLAMP) return static_cast<size_t>(std::clamp<int64_t>(i, 0, size - 1));
  const int64_t period = wrap == SIDERAY_MIRROR ? 2 * size : size;
  i = (i % period + period) % period;
  return static_cast<size_t>(i < size ? i : 2 * size - 1 - i);
}

struct Axis {
  size_t texel0, texel1;
  float weight1;
};

Axis bilinear_axis(float s, uint32_t size, sideray_wrap wrap) {
  const float x = reduce(s, wrap) * static_cast<float>(size) - 0.5f;
  const float base = std::floor(x);
  const auto i = static_cast<int64_t>(base);
  return {wrap_texel(i, size, wrap), wrap_texel(i + 1, size, wrap), x - base};
}

size_t nearest_texel(float s, uint32_t size, sideray_wrap wrap) {
  return wrap_texel(static_cast<int64_t>(std::floor(reduce(s, wrap) * static_cast<float>(size))), size, wrap);
}

template <typename Fetch>
auto sample_bilinear(const Level& level, const sideray_texture_slot& slot, glm::vec2 st, Fetch fetch) {
  const Axis x = bilinear_axis(st.x, level.width, slot.wrap_u);
  const Axis y = bilinear_axis(st.y, level.height, slot.wrap_v);
  const size_t row0 = y.texel0 * level.width, row1 = y.texel1 * level.width;
  const auto top = fetch(level, row0 + x.texel0) * (1.0f - x.weight1) + fetch(level, row0 + x.texel1) * x.weight1;
  const auto bottom = fetch(level, row1 + x.texel0) * (1.0f - x.weight1) + fetch(level, row1 + x.texel1) * x.weight1;
  return top * (1.0f - y.weight1) + bottom * y.weight1;
}

template <typename Fetch>
auto sample_level(const Level& level, const sideray_texture_slot& slot, glm::vec2 st, Fetch fetch) {
  if (slot.filter == SIDERAY_NEAREST) {
    const size_t x = nearest_texel(st.x, level.width, slot.wrap_u);
    const size_t y = nearest_texel(st.y, level.height, slot.wrap_v);
    return fetch(level, y * level.width + x);
  }
  return sample_bilinear(level, slot, st, fetch);
}

glm::vec2 texture_from_uv(const sideray_texture_slot& slot, glm::vec2 uv) {
  const float* m = slot.texture_from_uv;
  return {m[0] * uv.x + m[2] * uv.y + m[4], m[1] * uv.x + m[3] * uv.y + m[5]};
}

}  // namespace

glm::vec4 sample(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv, float level) {
  const glm::vec2 st = texture_from_uv(slot, uv);
  const FetchColor fetch{texture.srgb};
  if (slot.filter != SIDERAY_TRILINEAR || !(level > 0.0f)) return sample_level(texture.levels[0], slot, st, fetch);

  const auto last = static_cast<float>(texture.levels.size() - 1);
  const float clamped = std::min(level, last);
  const float floor_level = std::floor(clamped);
  const auto index = static_cast<size_t>(floor_level);
  const glm::vec4 fine = sample_level(texture.levels[index], slot, st, fetch);
  const float weight = clamped - floor_level;
  if (weight == 0.0f) return fine;
  return fine * (1.0f - weight) + sample_level(texture.levels[index + 1], slot, st, fetch) * weight;
}

float sample_alpha(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv) {
  return sample_level(texture.levels[0], slot, texture_from_uv(slot, uv), FetchAlpha{});
}

}  // namespace sideray::rt
