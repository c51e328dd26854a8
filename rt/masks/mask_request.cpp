#include "rt/masks/mask_request.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace sideray::rt {

sideray_mask_inputs default_mask_inputs() {
  sideray_mask_inputs in{};
  in.size = sizeof(in);
  in.inexact_bias = 0.5f;
  in.ao_distance = INFINITY;
  in.denoise = 1;
  return in;
}

bool ask_alike(const sideray_mask_inputs& a, const sideray_mask_inputs& b) {
  static_assert(sizeof(a) == sizeof(size_t) + 14 * sizeof(uint32_t), "padding would be compared too");
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

std::vector<uint32_t> lights_of(uint32_t mask) {
  std::vector<uint32_t> lights;
  for (; mask != 0; mask &= mask - 1) lights.push_back(static_cast<uint32_t>(std::countr_zero(mask)));
  return lights;
}

uint32_t light_masks_of(uint32_t lights, bool combined) {
  return static_cast<uint32_t>(std::popcount(lights)) + (combined ? 1u : 0u);
}

uint32_t light_masks_of(const MaskRequest& request) {
  return light_masks_of(request.shadow_lights, request.combined_lights != 0);
}

uint32_t mask_layers_of(const MaskRequest& request) {
  return light_masks_of(request) + (request.unhidden_sky ? 1u : 0u);
}

bool OcclusionMasks::is_tinted(uint32_t place) const {
  const size_t tiles = size_t{tint_columns()} * tint_rows(), first = tint_tile_index(place, 0);
  return std::any_of(tint_tiles.begin() + static_cast<ptrdiff_t>(first),
                     tint_tiles.begin() + static_cast<ptrdiff_t>(first + tiles), [](uint8_t tile) { return tile != 0; });
}

void OcclusionMasks::add_tint(uint32_t layer, bool filtered) {
  const size_t pixels = size_t{width} * height;
  tint_places.resize(layers);
  tint_places[layer] = ++tints;
  tint.resize(3 * pixels * tints, uint8_t{255});
  if (filtered) tint_distance.resize(pixels * tints, INFINITY);
  tint_tiles.resize(size_t{tint_columns()} * tint_rows() * tints);
  tint_lasts.resize(tints);
  tint_coloured.resize(tints);
}

void OcclusionMasks::forget_tints() {
  tints = 0;
  tint_places.assign(layers, 0);
  tint.clear();
  tint_distance.clear();
  tint_tiles.clear();
  tint_lasts.clear();
  tint_coloured.clear();
}

bool OcclusionMasks::in_penumbra(uint32_t layer, uint32_t column, uint32_t row) const {
  int around = 0;
  for (uint32_t v = row > 0 ? row - 1 : 0; v <= std::min(row + 1, filter_rows() - 1); ++v)
    for (uint32_t u = column > 0 ? column - 1 : 0; u <= std::min(column + 1, filter_columns() - 1); ++u)
      around |= seen[filter_index(layer, u, v)];
  return around == (seen_dark | seen_lit);
}

}  // namespace sideray::rt
