// Holds what the functions of ground truth share: the picture's camera and size, and the view that it is traced in. Any
// thread.
#pragma once

#include "bridge/base/check_inputs.h"
#include "bridge/base/versions.h"
#include "bridge/drawing/views.h"
#include "model/failure.h"
#include "rt/base/view.h"

namespace sideray::bridge {

inline void check_truth_size(uint32_t width, uint32_t height) {
  constexpr uint32_t longest_side = 16384;
  if (width < 1 || height < 1 || width > longest_side || height > longest_side)
    fail(SIDERAY_INVALID_ARGUMENT, "picture of {}x{}: sides must be 1 to {}", width, height, longest_side);
}

inline sideray_camera read_truth_camera(const sideray_camera* camera) {
  require(camera, "camera");
  const sideray_camera read = read_struct(camera, "camera", sideray_camera_init);
  check_camera(read);
  return read;
}

// `origin`: the origin of local space.
inline gl::RasterView truth_view(const sideray_camera& camera, uint32_t width, uint32_t height, glm::dvec3 origin) {
  return gl::make_raster_view(camera, glm::vec2(0.0f), {width, height, origin, true});
}

inline rt::TraceView trace_view(const gl::RasterView& view) {
  return {view.clip_from_local, view.local_from_clip, view.reversed_depth, view.zero_to_one_depth};
}

// Returns a plane whose dot product with (x, y, z, 1) of a local position is its depth along the view axis.
inline glm::dvec4 depth_plane(const gl::RasterView& view) {
  glm::dvec4 plane;
  for (int c = 0; c < 4; ++c) plane[c] = -view.view_from_local[c][2];
  return plane;
}

}  // namespace sideray::bridge
