// Makes random numbers that are functions of their arguments. Any thread.
#pragma once

#include <cstdint>

namespace sideray::scenes {

// Mixes the bits of a number, like a pcg (Jarzynski and Olano 2020, Hash Functions for GPU Rendering).
inline uint32_t mixed_bits(uint32_t v) {
  v = v * 747796405u + 2891336453u;
  v = ((v >> ((v >> 28) + 4)) ^ v) * 277803737u;
  return (v >> 22) ^ v;
}

// Returns a random number in [0, 1) that depends on its arguments alone. Inline, since it paints textures.
inline float hash01(uint32_t a, uint32_t b = 0, uint32_t c = 0) {
  return static_cast<float>(mixed_bits(a + mixed_bits(b + mixed_bits(c))) >> 8) * 0x1p-24f;
}

}  // namespace sideray::scenes
