// Camera matrices of the rasterizer. Plain arithmetic in double precision; any thread.
#pragma once

#include <glm/glm.hpp>

#include "gl/rasterizer.h"

namespace sideray::gl {

struct ViewTarget {
  uint32_t width = 0, height = 0;
  glm::dvec3 origin{0.0};     // of the snapshot's local space
  bool clip_control = false;  // reversed depth in 0..w where it can be had
};

// Throws Failure (INVALID_ARGUMENT) on a camera that sees nothing.
RasterView make_raster_view(const sideray_camera& camera, glm::vec2 jitter, const ViewTarget& target);

// How a pixel and its window depth become a position again; see shaders/raster_light.frag.glsl.
struct ViewRays {
  glm::vec3 origin, origin_x, origin_y, ray, ray_x, ray_y;
  glm::vec2 along_from_depth;
};
ViewRays make_view_rays(const RasterView& view);

// Whether a box lies wholly beside or behind what a matrix shows; false where that is not certain.
bool is_outside(const glm::mat4& clip_from_local, const model::Bounds& bounds);

}  // namespace sideray::gl
