// Computes where the rays of a tile's opaque pixels start: on the surface that the depth buffer shows, moved off it by
// no more than the depth may be wrong. Holds scratch memory: one object per thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/view_rays.h"
#include "rt/masks/mask_request.h"

namespace sideray::rt {

struct DepthPoint {
  uint16_t x, y;
  // These lie on the side of the surface that the eye sees, and behind it: neither is inside whatever was drawn there.
  glm::vec3 front, back;
  glm::vec3 normal;  // geometric, unit, on the eye's side
  bool inexact;      // takes the inexact test
  float bias;        // the bias B of the inexact test here, 0 where nothing may move
  float doubt;       // sine of the angle by which steps of the depth may have turned the normal
  float skip;        // hits nearer than this may be the surface itself: it is not known on which side a ray starts
  // Returns where a ray starts. In doubt it is in front: there a surface that faces the direction does not shadow
  // itself, and one that does not is rightly dark.
  glm::vec3 origin(glm::vec3 direction) const { return glm::dot(direction, normal) >= -doubt ? front : back; }
};

class DepthPoints {
 public:
  static constexpr uint32_t tile_size = 32;

  // Returns the points of a tile's pixels where something was drawn, in blocks of 4x4. They replace the last tile's.
  const std::vector<DepthPoint>& gather(const MaskRequest& request, const ViewRays& view, uint32_t x0, uint32_t y0);

 private:
  static constexpr uint32_t border = 2, side = tile_size + 2 * border;
  struct Seen {
    glm::dvec3 drawn;     // position by the depth buffer
    glm::dvec3 position;  // with the rest pose's offset where that counts
    double distance;      // along the view ray; infinite = nothing
    double w;             // perspective: falls in proportion to the depth
    double off;           // how much nearer it may be by the format's step and rounding; not set in the border
    glm::vec3 direction;  // direction of the view ray
    bool resting, marked;
  };

  void see(const MaskRequest& request, const ViewRays& view, uint32_t x0, uint32_t y0);
  // Leads from one pixel to the next of a surface.
  struct Step {
    glm::dvec3 along;
    double slope;  // change of the depth, along the view ray
    double breadth;
    bool known;  // otherwise neither neighbour shows the same surface, and it may be tilted by any angle
  };
  // Takes the neighbour at `index` + or - `stride` that is nearer in distance: the surface goes on there, if anywhere.
  Step step(size_t index, size_t stride, bool perspective) const;
  // Bounds the slope of the depth along the view ray: the steeper of the surface's two sides counts.
  double slope(size_t index, size_t stride, bool perspective, bool goes_on_after) const;
  static glm::dvec3 normal(const Step& across, const Step& up, const glm::dvec3& toward);
  // Refines a point by the hit of a ray with the surface: nothing is rounded but the point itself.
  static DepthPoint exact(DepthPoint point, const Seen& here, const OpaquePoint& met, double least);
  DepthPoint point(const MaskRequest& request, const ViewRays& view, uint32_t x, uint32_t y, size_t index) const;

  std::vector<Seen> seen_ = std::vector<Seen>(size_t{side} * side);
  std::vector<DepthPoint> points_;
};

}  // namespace sideray::rt
