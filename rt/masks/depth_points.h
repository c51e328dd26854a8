// Computes where the rays of a tile's opaque pixels start: at the surface in the depth buffer, offset by no more than
// the depth's error. It has scratch memory: one object per thread.
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
  // The start points in front of the surface, on the eye's side, and behind it, both offset by the depth's error.
  glm::vec3 front, back;
  glm::vec3 normal;  // geometric, unit, on the eye's side
  bool inexact;      // takes the inexact test
  float bias;        // bias B of the inexact test, 0 if nothing may move
  float doubt;       // sine of the angle by which the depth's quantization may have turned the normal
  float skip;        // hits nearer than this are ignored, because they may be the surface itself
  // Returns where a ray starts. In doubt it starts in front: there a surface that faces the direction does not shadow
  // itself, and one that faces away is dark, as it should be.
  glm::vec3 origin(glm::vec3 direction) const { return glm::dot(direction, normal) >= -doubt ? front : back; }
};

// Returns one of a tile's points by its index; it must be in `drawn`.
DepthPoint point_at(const PointTile& tile, uint32_t index);

// Calls work(index) for each set bit of the tile's blocks.
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

  // Returns the points of a tile's pixels with a surface. They are valid until the next call.
  const PointTile& gather(const MaskRequest& request, const ViewRays& view, uint32_t x0, uint32_t y0);
  // Drops the last tile's points, except those in the middle of squares of step x step pixels. `step` must divide the
  // tile's side.
  const PointTile& thin(uint32_t step);
  // Does the same pixel by pixel: for orthographic views, for points from rays, and for testing gather().
  const PointTile& gather_singly(const MaskRequest& request, const ViewRays& view, uint32_t x0, uint32_t y0);

 private:
  class Single;

  void see(const MaskRequest& request, const PointView& view, uint32_t x0, uint32_t y0);
  void mark(const MaskRequest& request, uint32_t x0, uint32_t y0);
  void rest(const MaskRequest& request, uint32_t x0, uint32_t y0);

  const PointKernels* kernels_;
  // Allocated by the first gather(): under a budget many frames gather no points.
  std::unique_ptr<SeenPixels> seen_;
  std::unique_ptr<PointTile> tile_;
  std::unique_ptr<Single> single_;
};

}  // namespace sideray::rt
