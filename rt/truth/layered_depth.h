// Finds every surface that the pixels of a picture see, opaque and translucent in one order: along straight rays
// through everything, or along refracted paths. Plain memory. One call at a time.
#pragma once

#include <sideray/ground_truth.h>

#include <glm/glm.hpp>

#include "rt/base/view.h"
#include "rt/refraction/refraction.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

struct LayeredDepthRequest {
  TraceView view;
  glm::dvec4 depth_plane;  // its dot product with a local position (x, y, z, 1) is the depth along the view axis
  sideray_layered_depth_desc wanted;  // checked; its camera is not read
};

class LayeredDepthTracing {
 public:
  // Fills the arrays that the request points to.
  void trace(const LayeredDepthRequest& request, TracedScene& scene);

 private:
  KeptRefractionScene refraction_;
};

}  // namespace sideray::rt
