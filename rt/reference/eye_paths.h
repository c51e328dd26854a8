// Starts paths at the surfaces that primary rays hit. All surfaces on a ray up to its first random continuation are
// found once; a given number of paths is distributed among them. It has scratch memory: one object per thread.
#pragma once

#include <vector>

#include "rt/reference/path_tracer.h"

namespace sideray::rt {

struct EyeRay {
  Ray ray;
  Cone cone;
  Hit opaque;    // the first opaque surface on the straight ray; no_instance: the sky
  uint32_t key;  // of the pixel's random numbers, for all positions
};

struct EyeSettings {
  uint32_t samples;    // paths of each ray, at least 1
  uint32_t position;   // the number of the sample position
  bool is_end_given;   // paths do not light the surface at the straight ray's end
  MediumStack media;   // the media around the eye
};

// Holds the result of a ray.
struct SeenByEye {
  glm::vec3 radiance[2];    // from independent halves of the paths; with one path, the same value twice
  glm::vec3 transmittance;  // to the straight ray's end, if paths do not light it: it is given, or is the sky
  glm::vec3 sky;            // to the sky along bent rays, whose radiance includes the sky
  uint32_t surfaces;        // translucent surfaces hit
};

class EyePaths {
 public:
  void trace(std::span<const EyeRay> rays, const EyeSettings& settings, PathTracer& tracer, std::vector<SeenByEye>& seen);

 private:
  // Is a primary ray with the surfaces found so far.
  struct View {
    LightWay way;
    uint32_t ray;
    glm::vec3 through;
  };
  // Is a surface at which paths may start.
  struct Stop {
    LightWay way;  // up to it
    WayEvent event;
    bool passes;   // paths pass it in random directions; false: it reflects them
    uint32_t ray;
    glm::vec3 weight;  // of their light in the pixel
    float importance;  // relative to the ray's other stops; the stop gets paths in proportion
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
  std::vector<uint32_t> order_;  // order of the stops, by ray
  std::vector<PathStart> starts_;
  std::vector<PathSum> sums_;    // for each ray: two halves, and their common part
  std::vector<SeenByEye>* seen_ = nullptr;
  PathTracer* tracer_ = nullptr;
};

}  // namespace sideray::rt
