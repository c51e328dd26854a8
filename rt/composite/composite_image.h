// Holds translucent surfaces composited along the rays: the answer to a FrameRequest where nothing is cached. Plain
// values; the threads of a frame write different texels.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::rt {

struct CompositeImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance, transmittance;   // four halfs a texel; transmittance 1 where nothing was hit
  std::vector<uint8_t> traced_tiles, dirty_tiles;  // as in LayerCache
  // Half of the difference between the estimates of radiance, as in ReferenceImage; empty without light_samples.
  std::vector<glm::vec3> half_difference;
};

}  // namespace sideray::rt
