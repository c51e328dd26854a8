#include "bridge/transport/rgb9e5.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace sideray::bridge {
namespace {

constexpr int32_t largest_half = 0x7bfc;      // 65408
constexpr int32_t least_exponent = 127 - 16;  // of a float whose shared exponent is 0

// By value: references keep compilers from making vectors.
int32_t smaller(int32_t a, int32_t b) {
  return a < b ? a : b;
}
int32_t larger(int32_t a, int32_t b) {
  return a < b ? b : a;
}

// Integers and products alone: no branches, so that compilers make vectors of it, and nothing denormal, which threads
// may take for 0.
float float_from(int32_t half) {
  const int32_t exponent = half >> 10, normal = smaller(exponent, 1);
  const int32_t mantissa = (half & 0x3ff) | normal << 10;
  return static_cast<float>(mantissa) * std::bit_cast<float>((exponent - normal + 103) << 23);
}

// `rg`, `ba`: two halfs each, of which the last is left out.
uint32_t packed_from(uint32_t rg, uint32_t ba) {
  const int32_t r = smaller(static_cast<int32_t>(rg & 0xffff), largest_half);
  const int32_t g = smaller(static_cast<int32_t>(rg >> 16), largest_half);
  const int32_t b = smaller(static_cast<int32_t>(ba & 0xffff), largest_half);
  const float most = float_from(larger(larger(r, g), b));
  const int32_t exponent = larger((std::bit_cast<int32_t>(most) >> 23) - least_exponent, 0);
  // 1 / step, with step = 2^(exponent - 24). Halfs have 11 bits: products and sums below are exact.
  const float scale = std::bit_cast<float>((127 + 24 - exponent) << 23);
  const int32_t carried = static_cast<int32_t>(most * scale + 0.5f) >> 9;
  const float s = std::bit_cast<float>((127 + 24 - exponent - carried) << 23);
  const auto mantissa = [s](int32_t c) {
    return static_cast<uint32_t>(static_cast<int32_t>(float_from(c) * s + 0.5f));
  };
  return mantissa(r) | mantissa(g) << 9 | mantissa(b) << 18 | static_cast<uint32_t>(exponent + carried) << 27;
}

}  // namespace

void pack_rgb9e5(const uint16_t* halfs, uint32_t* packed, size_t texels) {
  constexpr size_t block = 64;
  uint32_t pairs[2 * block] = {};
  for (size_t first = 0; first < texels; first += block) {
    const size_t count = std::min(block, texels - first);
    std::memcpy(pairs, halfs + 4 * first, 8 * count);
    uint32_t result[block];
    for (size_t i = 0; i < block; ++i) result[i] = packed_from(pairs[2 * i], pairs[2 * i + 1]);
    std::memcpy(packed + first, result, 4 * count);
  }
}

glm::vec3 unpack_rgb9e5(uint32_t packed) {
  const float step = std::ldexp(1.0f, static_cast<int>(packed >> 27) - 24);
  return step * glm::vec3(packed & 0x1ff, packed >> 9 & 0x1ff, packed >> 18 & 0x1ff);
}

}  // namespace sideray::bridge
