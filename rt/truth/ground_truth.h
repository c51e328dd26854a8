// Finds what each pixel of a picture shows, its glass included, what stands behind the glass along the bent path, and where
// the picture shows that place without the glass: by rays through the pixels' centres. Plain memory; pixels: row 0 is the
// bottom row. One call at a time.
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
  glm::dvec4 depth_plane;  // (x, y, z, 1) of a local position times this is its depth along the view axis
  uint32_t width = 0, height = 0;
  bool behind = false;  // fill GroundTruthImage::behind
};

struct SeenSurface {
  uint32_t surface = 0, primitive = 0;  // surface id; triangle + 1, 0 = nothing
  float z = std::numeric_limits<float>::infinity();
  glm::vec3 normal{0.0f};  // shading normal on the side that it is seen from
};

// Says how a pixel's path ends.
enum class PathState : uint32_t {
  straight = 0,      // nothing bends it
  surface = 1,       // bent, at an opaque surface
  surroundings = 2,  // bent, out of the scene
  unfinished = 3     // still in glass after as many surfaces as a path may hit
};

// Says what the straight ray to the place where a path ends shows.
enum class PlaceState : uint32_t {
  undefined = 0,  // no pixel looks that way, or there is no such place
  visible = 1,
  outside = 2,  // beside the picture, before its near plane or beyond its far plane
  hidden = 3    // behind another opaque surface, or on a side that is not drawn
};

struct PathTruth {
  SeenSurface end;
  float length = std::numeric_limits<float>::infinity();  // of the path, from the camera; +inf = no surface
  uint32_t turns = 0;  // surfaces that refracted or reflected it
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
