// Computes how far the surfaces in pixels have moved since the previous frame, as gl/passes/motion_pass.cpp does. Row 0
// of pixels is the bottom row.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "model/snapshot.h"
#include "rt/drawing/opaque_pixels.h"

namespace sideray::rt {

struct MotionRequest {
  TraceView view;                             // of the frame, as traced
  glm::dvec2 jitter{0.0};                     // in -1..1: the offset of the picture by jitter
  glm::dmat4 clip_from_local_before{1.0};     // of the previous frame, without jitter, from its own local space
  const model::Snapshot* before = nullptr;    // null: there is no previous frame, so nothing moved
  bool sky_stays = false;                     // one of the views is orthographic
};

// Returns the position of each pixel's surface, or of the sky, minus its previous one, in pixels, x to the right and y
// up, without jitter.
std::vector<glm::vec2> trace_motion(const MotionRequest& request, const OpaquePixels& pixels, TracedScene& scene);

}  // namespace sideray::rt
