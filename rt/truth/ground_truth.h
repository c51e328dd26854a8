// Finds by rays through the pixels' centres what each pixel shows, glass included; what its refracted path ends at
// behind the glass; and where that place would be in the picture without the glass. Plain memory; row 0 of pixels is
// the bottom row. One call at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include "rt/base/view.h"
#include "rt/refraction/refraction.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

struct GroundTruthRequest {
  TraceView view;
  glm::dvec4 depth_plane;  // its dot product with a local position (x, y, z, 1) is the depth along the view axis
  uint32_t width = 0, height = 0;
  bool behind = false;  // fill GroundTruthImage::behind
};

struct SeenSurface {
  uint32_t surface = 0, primitive = 0;  // surface id; triangle + 1, 0 = nothing
  float z = std::numeric_limits<float>::infinity();
  glm::vec3 normal{0.0f};  // shading normal, on the viewer's side
};

// Says how a pixel's path through glass ends.
enum class PathState : uint32_t {
  straight = 0,      // not bent by any surface
  surface = 1,       // bent, at an opaque surface
  surroundings = 2,  // bent, out of the scene
  unfinished = 3     // still in glass when the limit of surfaces was reached
};

// Says whether the straight ray from the eye to the end of a bent path reaches it.
enum class PlaceState : uint32_t {
  undefined = 0,  // no pixel looks in that direction, or the path has no end
  visible = 1,
  outside = 2,  // outside the picture, in front of its near plane or beyond its far plane
  hidden = 3    // behind another opaque surface, or on a side that is not drawn
};

struct PathTruth {
  SeenSurface end;
  float length = std::numeric_limits<float>::infinity();  // of the path, from the camera; +inf = no surface
  uint32_t turns = 0;  // number of surfaces that refracted or reflected it
  PathState state = PathState::straight;
  glm::vec2 place{std::numeric_limits<float>::quiet_NaN()};  // pixels from the TOP left corner
  PlaceState seen = PlaceState::undefined;
};

struct GroundTruthImage {
  std::vector<SeenSurface> first, glass;  // the first surface; the first translucent one
  std::vector<PathTruth> behind;          // empty unless requested
};

class GroundTruthTracing {
 public:
  GroundTruthImage trace(const GroundTruthRequest& request, TracedScene& scene);

 private:
  KeptRefractionScene refraction_;
};

}  // namespace sideray::rt
