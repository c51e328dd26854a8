#include "rt/masks/mask_request.h"

#include <algorithm>
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

uint32_t mask_layers_of(const MaskRequest& request) {
  return light_masks_of(request) + (request.unhidden ? 1u : 0u);
}

bool OcclusionMasks::in_penumbra(uint32_t layer, uint32_t column, uint32_t row) const {
  int around = 0;
  for (uint32_t v = row > 0 ? row - 1 : 0; v <= std::min(row + 1, filter_rows() - 1); ++v)
    for (uint32_t u = column > 0 ? column - 1 : 0; u <= std::min(column + 1, filter_columns() - 1); ++u)
      around |= seen[filter_index(layer, u, v)];
  return around == (seen_dark | seen_lit);
}

}  // namespace sideray::rt
