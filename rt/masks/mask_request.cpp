#include "rt/masks/mask_request.h"

#include <bit>

namespace sideray::rt {

std::vector<uint32_t> lights_of(uint32_t mask) {
  std::vector<uint32_t> lights;
  for (; mask != 0; mask &= mask - 1) lights.push_back(static_cast<uint32_t>(std::countr_zero(mask)));
  return lights;
}

uint32_t light_masks_of(const MaskRequest& request) {
  return static_cast<uint32_t>(std::popcount(request.lights)) + (request.combined_lights ? 1u : 0u);
}

}  // namespace sideray::rt
