// Finds the transmittance of translucent surfaces between a light and the pixels of a tile, tracing some pixels and
// interpolating the others.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "rt/light/straight_light.h"
#include "rt/points/point_kernels.h"

namespace sideray::rt {

// Holds the transmittance of red, green and blue, 255 = 1, and the distance along the ray of the first surface that
// absorbs or reflects, infinite if there is none. Row by row, unlike the pixels of a PointTile.
struct TintTile {
  uint32_t layer, tile;
  std::array<std::array<uint8_t, point_tile_pixels>, 3> left;
  std::array<float, point_tile_pixels> distance;
};

// Describes the rays of a tile's pixels to one light.
struct TileLight {
  uint32_t layer, tile;  // names, for TintTile
  RayColumns rays;
  const uint16_t* pixels;  // the index of each ray's pixel in the tile
  const uint8_t* blocked;  // 1: the ray has an opaque occluder
  const uint32_t* orders;  // SampleKeys::order of the points on the light
  const RayLight* to;      // null: the rays lead to several lights
  bool filtered;  // the tints are filtered later, so fewer pixels suffice
};

// Has scratch memory: one object per thread.
class TileTints {
 public:
  // The caller keeps both objects alive.
  void begin(const ShadingScene& scene, const Intersector& intersector) { straight_.begin(scene, intersector); }
  // Appends the light's tints in the tile to `found`, if there are any. Returns the number of rays.
  uint64_t trace(const TileLight& light);

  std::deque<TintTile> found;

 private:
  class Blocks;

  void rank_pixels(const uint32_t* orders);
  // Follows the unblocked rays whose pixel is wanted.
  template <typename Wanted>
  void follow(const TileLight& light, Blocks& blocks, const Wanted& wanted);
  void note(const TileLight& light, size_t ray, Blocks& blocks);
  void fill_between(uint32_t pixel);
  void fill_shadows(const TileLight& light);

  StraightLight straight_;
  std::vector<Ray> clear_, chosen_;  // rays without an opaque occluder; rays that are followed
  std::vector<uint32_t> of_clear_, of_chosen_;  // their pixels
  std::array<uint8_t, point_tile_pixels> known_{};  // row by row: 1 = the pixel's ray was followed
  std::array<uint8_t, point_tile_pixels> ranks_{};  // row by row: the order in which rays are followed
  TintTile* tint_ = nullptr;                        // null: nothing is tinted so far
};

}  // namespace sideray::rt
