// Computes the rasterizer's camera matrices. Plain arithmetic in double precision; any thread may call it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "model/snapshot.h"

namespace sideray::gl {

// Describes a camera in the snapshot's local space. Depth is reversed with clip z in 0..w where the driver has clip
// control, ordinary -w..w otherwise: Rasterizer::make_view decides.
struct RasterView {
  glm::dmat4 clip_from_local{1.0}, local_from_clip{1.0};  // jitter included
  glm::dmat4 view_from_local{1.0};
  glm::dvec2 jitter{0.0};   // in clip space, -1..1: the shift of what is drawn
  glm::vec3 eye{0.0f};      // perspective
  glm::vec3 forward{0.0f};  // unit, the way the camera looks
  bool orthographic = false, reversed_depth = false, zero_to_one_depth = false;
  float z_near = 0, z_far = 0;  // z_far 0 = infinite
  float half_height = 0, yfov = 0, fx_per_fy = 1;
};

struct ViewTarget {
  uint32_t width = 0, height = 0;
  glm::dvec3 origin{0.0};     // the origin of the snapshot's local space
  bool clip_control = false;  // whether reversed depth in 0..w is available
};

// Throws Failure (INVALID_ARGUMENT) on a camera that sees nothing.
RasterView make_raster_view(const sideray_camera& camera, glm::vec2 jitter, const ViewTarget& target);

// Maps a pixel and its window depth to a position; see shaders/light/raster_light.frag.glsl.
struct ViewRays {
  glm::vec3 origin, origin_x, origin_y, ray, ray_x, ray_y;
  glm::vec2 along_from_depth;
};
ViewRays make_view_rays(const RasterView& view);

// Returns whether the sphere around a box looks smaller than half a pixel. Passes of the view skip such a box: in most
// frames it covers no pixel centre, and otherwise it flickers.
bool is_too_small(const RasterView& view, uint32_t height, const model::Bounds& bounds);

// Returns whether a box lies wholly beside or behind a matrix's frustum; false where that is not certain.
bool is_outside(const glm::mat4& clip_from_local, const model::Bounds& bounds);

}  // namespace sideray::gl
