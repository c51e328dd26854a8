// A request for the translucent surfaces of a frame's pixels composited along their rays, and the image that answers
// it. Plain values; any thread. Pixels: row 0 is the bottom row.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/layers/layer_request.h"

namespace sideray::rt {

struct CompositeRequest : LayerRequest {
  uint32_t light_samples = 0;  // above 0, surfaces are shaded as in the reference
  uint32_t bounces = 1;        // with light samples: as in ReferenceRequest
  bool refraction = false;
  bool particles = false;
};

struct CompositeImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance, transmittance;   // four halfs a texel; transmittance 1 where nothing was hit
  std::vector<uint8_t> traced_tiles, dirty_tiles;  // as in LayerCache
  std::vector<glm::vec3> half_difference;          // of radiance, as in ReferenceImage; empty without light_samples
};

}  // namespace sideray::rt
