// Finds every surface that the pixels of a picture look at, opaque and translucent in one order: along straight rays, through
// everything, or along the paths that light takes. Plain memory. One call at a time.
#pragma once

#include <sideray/ground_truth.h>

#include <glm/glm.hpp>

#include "rt/base/view.h"
#include "rt/refraction/refraction.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

struct LayeredDepthRequest {
  TraceView view;
  glm::dvec4 depth_plane;  // (x, y, z, 1) of a local position times this is its depth along the view axis
  sideray_layered_depth_desc wanted;  // checked; its camera is not read
};

class LayeredDepthTracing {
 public:
  // Fills the arrays that the request names.
  void trace(const LayeredDepthRequest& request, TracedScene& scene);

 private:
  KeptRefractionScene refraction_;
};

}  // namespace sideray::rt
