// Finds what translucent surfaces leave of a light in the pixels of a tile, tracing some of them and interpolating the
// others.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "rt/points/point_tile.h"
#include "rt/light/straight_light.h"

namespace sideray::rt {

// Holds what is left of red, green and blue, 255 = all, and the distance along the ray of the first surface that
// absorbs or reflects, infinite if there is none. Row by row, unlike the pixels of a PointTile.
struct TintTile {
  uint32_t layer, tile;
  std::array<std::array<uint8_t, point_tile_pixels>, 3> left;
  std::array<float, point_tile_pixels> distance;
};

// The rays of a tile's pixels to one light.
struct TileLight {
  uint32_t layer, tile;  // names, for TintTile
  RayColumns rays;
  const uint16_t* pixels;  // the index of each ray's pixel in the tile
  const uint8_t* blocked;  // 1: something opaque stops the ray
  // Tints are filtered: where neighbours differ, every other pixel is traced, and the rest in the next frame.
  bool filtered;
  uint32_t seed;
};

// Holds scratch memory: one object per thread.
class TileTints {
 public:
  // The caller keeps both.
  void begin(const ShadingScene& scene, const Intersector& intersector) { straight_.begin(scene, intersector); }
  // Appends to `found` what a light has in the tile, if anything is tinted there. Returns how many rays were followed.
  uint64_t trace(const TileLight& light);

  std::deque<TintTile> found;

 private:
  class Blocks;

  // Follows the rays in chosen_.
  void follow(const TileLight& light, Blocks& blocks);
  void fill_between(uint32_t pixel);
  void fill_shadows(const TileLight& light);

  StraightLight straight_;
  std::vector<Ray> clear_, chosen_;  // rays that nothing opaque stops; those that are followed
  std::vector<uint32_t> of_clear_, of_chosen_;  // their pixels
  std::array<uint8_t, point_tile_pixels> known_{};  // row by row: 1 = its ray was followed
  TintTile* tint_ = nullptr;                        // null: nothing has been tinted yet
};

}  // namespace sideray::rt
