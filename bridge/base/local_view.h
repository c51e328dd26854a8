// Converts a host's camera to a snapshot's local space and to the snippet's uniforms. Any thread.
#pragma once

#include <sideray/sideray.h>

#include <glm/glm.hpp>

#include "rt/base/view.h"

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) where the matrices are not finite, or not inverse to each other.
void check_view(const sideray_view& view);

// Returns the view of an engine's matrices. Throws Failure (INVALID_ARGUMENT) where they cannot be a camera's.
sideray_view view_of_matrices(const double* projection, const double* modelview);

// Converts from world to local space: subtracts the snapshot's origin in double precision.
rt::TraceView local_view(const sideray_view& view, glm::dvec3 origin);

// Uniforms of sideray.glsl for a frame of this size and positions measured from `origin` (0 = world space).
struct SnippetView {
  glm::vec4 eye;         // xyz = eye, w = 1; or unit view direction, w = 0
  glm::vec4 near_plane;  // xyz = unit view direction; w: orthographic
  glm::mat3 ray_from_pixel;
  glm::mat4 clip_from_position;
};
SnippetView snippet_view(const sideray_view& view, uint32_t width, uint32_t height, glm::dvec3 origin);

}  // namespace sideray::bridge
