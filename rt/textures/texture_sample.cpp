#include "rt/textures/texture_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "elementary/functions.h"

namespace sideray::rt {
namespace {

using Level = model::Texture::Level;

// Holds four channels, or one weight four times.
using Four = float __attribute__((vector_size(16)));

struct Decode {
  // Tables from codes 0..255 to 0..1, and to linear light (IEC 61966-2-1, as OpenGL decodes it: before filtering, alpha
  // unchanged).
  std::array<float, 256> plain, srgb;
};

const Decode decode = [] {
  Decode d{};
  for (size_t i = 0; i < d.plain.size(); ++i) {
    const double c = static_cast<double>(i) / 255.0;
    d.plain[i] = static_cast<float>(i) * (1.0f / 255.0f);
    d.srgb[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : elementary::pow((c + 0.055) / 1.055, 2.4));
  }
  return d;
}();

struct FetchColor {
  const float* color;
  Four operator()(const Level& level, uint32_t texel) const {
    const uint8_t* p = level.rgba.data() + size_t{4} * texel;
    return Four{color[p[0]], color[p[1]], color[p[2]], decode.plain[p[3]]};
  }
};

struct FetchAlpha {
  float operator()(const Level& level, uint32_t texel) const { return decode.plain[level.rgba[size_t{4} * texel + 3]]; }
};

// Moves a coordinate into one period (two for MIRROR), so that the integers below stay small.
float reduce(float s, sideray_wrap wrap) {
  if (!std::isfinite(s)) return 0.0f;
  if (wrap == SIDERAY_CLAMP) return std::clamp(s, 0.0f, 1.0f);
  if (wrap == SIDERAY_MIRROR) return s - 2.0f * std::floor(0.5f * s);
  return s - std::floor(s);
}

// `i` is at most one texel outside the period of reduce(), so no division is needed.
[[gnu::always_inline]] inline uint32_t wrap_texel(int32_t i, int32_t size, sideray_wrap wrap) {
  if (wrap == SIDERAY_CLAMP) return static_cast<uint32_t>(std::clamp(i, 0, size - 1));
  const int32_t period = wrap == SIDERAY_MIRROR ? 2 * size : size;
  i = i < 0 ? i + period : i;
  i = i >= period ? i - period : i;
  return static_cast<uint32_t>(i < size ? i : 2 * size - 1 - i);
}

struct Axis {
  uint32_t texel0, texel1;
  float weight1;
};

[[gnu::always_inline]] inline Axis bilinear_axis(float reduced, uint32_t size, sideray_wrap wrap) {
  const float x = reduced * static_cast<float>(size) - 0.5f;
  const float base = std::floor(x);
  const auto i = static_cast<int32_t>(base), n = static_cast<int32_t>(size);
  return {wrap_texel(i, n, wrap), wrap_texel(i + 1, n, wrap), x - base};
}

uint32_t nearest_texel(float reduced, uint32_t size, sideray_wrap wrap) {
  return wrap_texel(static_cast<int32_t>(std::floor(reduced * static_cast<float>(size))), static_cast<int32_t>(size),
                    wrap);
}

template <typename Fetch>
auto sample_bilinear(const Level& level, const sideray_texture_slot& slot, glm::vec2 reduced, Fetch fetch) {
  const Axis x = bilinear_axis(reduced.x, level.width, slot.wrap_u);
  const Axis y = bilinear_axis(reduced.y, level.height, slot.wrap_v);
  const uint32_t row0 = y.texel0 * level.width, row1 = y.texel1 * level.width;
  const auto top = fetch(level, row0 + x.texel0) * (1.0f - x.weight1) + fetch(level, row0 + x.texel1) * x.weight1;
  const auto bottom = fetch(level, row1 + x.texel0) * (1.0f - x.weight1) + fetch(level, row1 + x.texel1) * x.weight1;
  return top * (1.0f - y.weight1) + bottom * y.weight1;
}

// The coordinate must come from reduce().
template <typename Fetch>
auto sample_level(const Level& level, const sideray_texture_slot& slot, glm::vec2 reduced, Fetch fetch) {
  if (slot.filter == SIDERAY_NEAREST) {
    const uint32_t x = nearest_texel(reduced.x, level.width, slot.wrap_u);
    const uint32_t y = nearest_texel(reduced.y, level.height, slot.wrap_v);
    return fetch(level, y * level.width + x);
  }
  return sample_bilinear(level, slot, reduced, fetch);
}

// Applies the slot's map and reduces the result.
glm::vec2 coordinates(const sideray_texture_slot& slot, glm::vec2 uv) {
  const float* m = slot.texture_from_uv;
  return {reduce(m[0] * uv.x + m[2] * uv.y + m[4], slot.wrap_u), reduce(m[1] * uv.x + m[3] * uv.y + m[5], slot.wrap_v)};
}

// Reads any mip level with `fetch`.
template <typename Fetch>
auto sample_any_level(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv, float level,
                      Fetch fetch) {
  const glm::vec2 st = coordinates(slot, uv);
  if (slot.filter != SIDERAY_TRILINEAR || !(level > 0.0f)) return sample_level(texture.levels[0], slot, st, fetch);
  const auto last = static_cast<float>(texture.levels.size() - 1);
  const float clamped = std::min(level, last);
  const float floor_level = std::floor(clamped);
  const auto index = static_cast<size_t>(floor_level);
  const auto fine = sample_level(texture.levels[index], slot, st, fetch);
  const float weight = clamped - floor_level;
  if (weight == 0.0f) return fine;
  return fine * (1.0f - weight) + sample_level(texture.levels[index + 1], slot, st, fetch) * weight;
}

}  // namespace

glm::vec4 sample(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv, float level) {
  const FetchColor fetch{texture.srgb ? decode.srgb.data() : decode.plain.data()};
  const Four v = sample_any_level(texture, slot, uv, level, fetch);
  return {v[0], v[1], v[2], v[3]};
}

float sample_alpha(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv, float level) {
  return sample_any_level(texture, slot, uv, level, FetchAlpha{});
}

const float* srgb_decode_table() {
  return decode.srgb.data();
}

AlphaRange alpha_range(const AlphaGrid& grid, const sideray_texture_slot& slot, glm::vec2 uv) {
  constexpr float rounding = 1e-6f;  // error of the weights that add up texels
  const glm::vec2 st = coordinates(slot, uv);
  const AlphaBounds b = grid.at(st.x * static_cast<float>(grid.width()), st.y * static_cast<float>(grid.height()));
  return {decode.plain[b.least] - rounding, decode.plain[b.most] + rounding};
}

}  // namespace sideray::rt
