// Computes where the rays of a tile's opaque pixels start: on the surface that the depth buffer shows, moved off it by
// no more than the depth may be wrong. Holds scratch memory: one object per thread.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "rt/base/view_rays.h"
#include "rt/masks/mask_request.h"
#include "rt/points/point_kernels.h"

namespace sideray::rt {

struct DepthPoint {
  uint16_t x, y;
  // These lie on the side of the surface that the eye sees, and behind it: neither is inside whatever was drawn there.
  glm::vec3 front, back;
  glm::vec3 normal;  // geometric, unit, on the eye's side
  bool inexact;      // takes the inexact test
  float bias;        // the bias B of the inexact test here, 0 where nothing may move
  float doubt;       // sine of the angle by which steps of the depth may have turned the normal
  float skip;        // hits nearer than this may be the surface itself: the side on which a ray starts is unknown
  // Returns where a ray starts. In doubt it is in front: there a surface that faces the direction does not shadow
  // itself, and one that faces away is dark as it should be.
  glm::vec3 origin(glm::vec3 direction) const { return glm::dot(direction, normal) >= -doubt ? front : back; }
};

// Returns one of a tile's points by its index; it has to be drawn.
DepthPoint point_at(const PointTile& tile, uint32_t index);

// Calls work(index) for each bit of the tile's blocks.
template <typename Work>
void for_each_pixel(const uint16_t (&blocks)[tile_blocks], const Work& work) {
  for (uint32_t block = 0; block < tile_blocks; ++block)
    for (uint32_t bits = blocks[block]; bits != 0; bits &= bits - 1)
      work(block * block_pixels + static_cast<uint32_t>(std::countr_zero(bits)));
}

class DepthPoints {
 public:
  static constexpr uint32_t tile_size = point_tile_size;

  explicit DepthPoints(const PointKernels& kernels = point_kernels());
  ~DepthPoints();
  DepthPoints(DepthPoints&&) noexcept;
  DepthPoints& operator=(DepthPoints&&) noexcept;

  // Returns the points of a tile's pixels where something was drawn. They replace the last tile's.
  const PointTile& gather(const MaskRequest& request, const ViewRays& view, uint32_t x0, uint32_t y0);
  // Leaves of the last tile's points one in each square of step x step pixels, the one in its middle. `step` divides the tile.
  const PointTile& thin(uint32_t step);
  // Returns the same, one by one: for orthographic views, for points of rays, and to test the other by.
  const PointTile& gather_singly(const MaskRequest& request, const ViewRays& view, uint32_t x0, uint32_t y0);

 private:
  class Single;

  void see(const MaskRequest& request, const PointView& view, uint32_t x0, uint32_t y0);
  void mark(const MaskRequest& request, uint32_t x0, uint32_t y0);
  void rest(const MaskRequest& request, uint32_t x0, uint32_t y0);

  const PointKernels* kernels_;
  std::unique_ptr<SeenPixels> seen_;
  std::unique_ptr<PointTile> tile_;
  std::unique_ptr<Single> single_;
};

}  // namespace sideray::rt
