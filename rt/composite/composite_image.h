// Translucent surfaces composited along the rays: what a FrameRequest is answered with where nothing is cached.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::rt {

struct CompositeImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance, transmittance;   // four halfs a texel; transmittance 1 where nothing was met
  std::vector<uint8_t> traced_tiles, dirty_tiles;  // as in LayerCache
  std::vector<glm::vec3> half_difference;          // of radiance, as in ReferenceImage; empty without light_samples
};

}  // namespace sideray::rt
