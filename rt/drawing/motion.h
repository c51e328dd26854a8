// Says by how much what pixels show moved since the previous frame, as gl/passes/motion_pass.cpp draws it. Pixels: row
// 0 is the bottom row.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "model/snapshot.h"
#include "rt/drawing/opaque_pixels.h"

namespace sideray::rt {

struct MotionRequest {
  TraceView view;                             // of the frame, as its pixels were traced
  glm::dvec2 jitter{0.0};                     // in -1..1: by how much it moves what is drawn
  glm::dmat4 clip_from_local_before{1.0};     // of the previous frame, without jitter, in its own local space
  const model::Snapshot* before = nullptr;    // null: there is no frame before, and nothing moved
  bool sky_stays = false;                     // one of the views is orthographic
};

// Returns pixels, x to the right and y up, where the surface or the sky is minus where it was, jitter excluded.
std::vector<glm::vec2> trace_motion(const MotionRequest& request, const OpaquePixels& pixels, TracedScene& scene);

}  // namespace sideray::rt
