// Converts floats to the halfs of textures, rounded to nearest even. Any thread may call it.
#pragma once

#include <half.h>

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>

namespace sideray::rt {

inline constexpr float largest_half = 65504.0f;

// Converts radiance or transmittance, which are never negative: NaN becomes 0, and too large values the largest half.
inline uint16_t half_bits(float value) {
  return imath_float_to_half(value > 0.0f ? std::min(value, largest_half) : 0.0f);
}

// Does the same for values that may be negative.
inline uint16_t signed_half_bits(float value) {
  return imath_float_to_half(value > 0.0f ? std::min(value, largest_half) : value < 0.0f ? std::max(value, -largest_half) : 0.0f);
}

inline void store_rgba(uint16_t* texel, glm::vec3 rgb, float alpha) {
  texel[0] = half_bits(rgb.x);
  texel[1] = half_bits(rgb.y);
  texel[2] = half_bits(rgb.z);
  texel[3] = half_bits(alpha);
}

}  // namespace sideray::rt
