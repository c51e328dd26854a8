#include "rt/masks/mask_request.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

#include "rt/light/tint_tile.h"

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
  // `moving`, the last field, changes no mask.
  constexpr size_t compared = offsetof(sideray_mask_inputs, moving);
  static_assert(compared == sizeof(size_t) + 14 * sizeof(uint32_t) && sizeof(a) - compared <= 2 * sizeof(uint32_t),
                "padding would be compared, or a field not");
  return std::memcmp(&a, &b, compared) == 0;
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

void OcclusionMasks::store_tint(uint32_t place, size_t tile, const TintTile* found) {
  static_assert(tint_tile == point_tile_size);
  uint8_t& flag = tint_tiles[tint_tile_index(place, tile)];
  if (!found && !flag) return;
  const auto x0 = static_cast<uint32_t>(tile % tint_columns()) * tint_tile;
  const auto y0 = static_cast<uint32_t>(tile / tint_columns()) * tint_tile;
  const uint32_t across = std::min(tint_tile, width - x0);
  const auto write_row = [&](auto* row, const auto* from, auto nothing) {
    if (from)
      std::copy_n(from, across, row);
    else
      std::fill_n(row, across, nothing);
  };
  for (uint32_t j = 0; j < std::min(tint_tile, height - y0); ++j) {
    const size_t to = size_t{y0 + j} * width + x0, from = size_t{j} * tint_tile;
    for (uint32_t c = 0; c < 3; ++c)
      write_row(&tint_plane(place, c)[to], found ? &found->left[c][from] : nullptr, uint8_t{255});
    if (tint_distance.empty()) continue;
    const size_t plane = (size_t{place} - 1) * width * height;
    write_row(&tint_distance[plane + to], found ? &found->distance[from] : nullptr, INFINITY);
  }
  flag = found != nullptr;
}

bool OcclusionMasks::is_tile_tinted(uint32_t place, size_t tile) {
  static constexpr auto white = [] {
    std::array<uint8_t, tint_tile> row{};
    row.fill(255);
    return row;
  }();
  const auto x0 = static_cast<uint32_t>(tile % tint_columns()) * tint_tile;
  const auto y0 = static_cast<uint32_t>(tile / tint_columns()) * tint_tile;
  const uint32_t across = std::min(tint_tile, width - x0);
  for (uint32_t c = 0; c < 3; ++c)
    for (uint32_t y = y0; y < std::min(y0 + tint_tile, height); ++y)
      if (std::memcmp(&tint_plane(place, c)[size_t{y} * width + x0], white.data(), across) != 0) return true;
  return false;
}

void OcclusionMasks::find_tinted(Executor& executor, const std::function<bool(uint32_t layer, size_t tile)>& is_white) {
  if (tints == 0) return;
  const size_t columns = tint_columns(), rows = tint_rows();
  executor.run(layers * rows, [&](size_t i, uint32_t) {
    const auto layer = static_cast<uint32_t>(i / rows);
    const uint32_t place = tint_places[layer];
    for (size_t tile = i % rows * columns; place != 0 && tile < (i % rows + 1) * columns; ++tile)
      tint_tiles[tint_tile_index(place, tile)] = !is_white(layer, tile) && is_tile_tinted(place, tile);
  });
  for (uint32_t place = 1; place <= tints; ++place) tint_lasts[place - 1] = is_tinted(place);
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
