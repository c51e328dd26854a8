// Holds translucent surfaces composited along the pixels' rays. Plain values; any thread. Row 0 of pixels is the bottom
// row.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::rt {

struct CompositeImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance, transmittance;   // four halfs a texel; transmittance is 1 where nothing was hit
  std::vector<uint8_t> traced_tiles, dirty_tiles;  // as in LayerCache
  std::vector<glm::vec3> half_difference;          // of radiance, as in ReferenceImage; empty without light_samples
};

}  // namespace sideray::rt
