#include "scenes/content/hash.h"

namespace sideray::scenes {
namespace {

// pcg-like mixing (Jarzynski and Olano 2020, Hash Functions for GPU Rendering).
uint32_t mixed(uint32_t v) {
  v = v * 747796405u + 2891336453u;
  v = ((v >> ((v >> 28) + 4)) ^ v) * 277803737u;
  return (v >> 22) ^ v;
}

}  // namespace

float hash01(uint32_t a, uint32_t b, uint32_t c) {
  return static_cast<float>(mixed(a + mixed(b + mixed(c))) >> 8) * 0x1p-24f;
}

}  // namespace sideray::scenes
