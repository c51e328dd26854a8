// Names the frame and the scene whose paths are refracted, and finds the media at their start. Any thread may use it.
#pragma once

#include <glm/glm.hpp>

#include "rt/layers/layer_tracer.h"
#include "rt/surfaces/media.h"

namespace sideray::rt {

// Holds what all chunks of a frame share.
struct RefractionContext {
  const FrameContext* frame;
  const RefractionScene* scene;
  MediumStack at_eye;  // media at the eye of a perspective view
  bool exact;  // rough surfaces split rays into many directions, and rays continue to the last visible surface
};

RefractionContext refraction_context(const FrameContext& frame, const RefractionScene& scene, bool exact);

// Returns the solids around a point, the innermost on top.
MediumStack media_at(const RefractionScene& scene, const Intersector& intersector, glm::vec3 point);

}  // namespace sideray::rt
