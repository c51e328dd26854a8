// Starts paths from what the eye sees along its rays. Up to the first random continuation of a ray, everything that it
// crosses is found once; a given number of paths is shared out among the surfaces there. Holds scratch memory: one
// object per thread.
#pragma once

#include <vector>

#include "rt/reference/path_tracer.h"

namespace sideray::rt {

struct EyeRay {
  Ray ray;
  Cone cone;
  Hit opaque;    // that the eye sees along the ray straight on; no_instance: the sky
  uint32_t key;  // of the pixel's random numbers, for all positions
};

struct EyeSettings {
  uint32_t samples;    // paths of each ray, at least 1
  uint32_t position;   // the number of the sample position
  bool is_end_given;   // paths do not light what the eye sees straight on
  MediumStack media;   // in which the eye is
};

// Holds what is seen along a ray.
struct SeenByEye {
  glm::vec3 radiance[2];    // independent halves of the paths; with one path, the same twice
  glm::vec3 transmittance;  // of the straight ray's end where paths do not light that: it is given, or the sky
  glm::vec3 sky;            // to the sky along bent rays; their radiance includes the sky
  uint32_t surfaces;        // translucent surfaces hit
};

class EyePaths {
 public:
  void trace(std::span<const EyeRay> rays, const EyeSettings& settings, PathTracer& tracer, std::vector<SeenByEye>& seen);

 private:
  // A ray of the eye, with the surfaces found so far.
  struct View {
    LightWay way;
    uint32_t ray;
    glm::vec3 through;
  };
  // A surface from which paths may set out.
  struct Stop {
    LightWay way;  // up to it
    WayEvent event;
    bool passes;   // they pass it, in directions that are left to chance; otherwise it reflects them
    uint32_t ray;
    glm::vec3 weight;  // what the eye gets of their light
    float importance;  // of all stops of the ray, in proportion to which it gets paths
  };

  void find_stops(std::span<const EyeRay> rays, const EyeSettings& settings);
  bool go_on(View& view, const EyeSettings& settings);
  bool meet(View& view, WayEvent& event);
  void end(View& view, const EyeSettings& settings);
  void reflect(const View& view, const WayEvent& event, float cover);
  void share_out(std::span<const EyeRay> rays, const EyeSettings& settings);

  std::vector<View> views_, next_views_;
  std::vector<LightWay*> group_;
  std::vector<Stop> stops_;
  std::vector<uint32_t> order_;  // of stops, ray by ray
  std::vector<PathStart> starts_;
  std::vector<PathSum> sums_;    // of each ray: the halves, and what both have in common
  std::vector<SeenByEye>* seen_ = nullptr;
  PathTracer* tracer_ = nullptr;
};

}  // namespace sideray::rt
