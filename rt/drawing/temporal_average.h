// Averages the pictures of a sequence over time, as shaders/light/raster_temporal.frag.glsl does; keeps the last one. Pixels:
// row 0 is the bottom row. One call at a time.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "rt/base/executor.h"
#include "rt/drawing/opaque_pixels.h"

namespace sideray::rt {

struct AverageRequest {
  TraceView view;  // of the frame
  // Distance along the axis of the view of a clip-space position, times `share` of it: of this frame's view and of that
  // before, both from this frame's clip space.
  glm::dvec4 distance_now{0.0}, distance_before{0.0}, share{0.0};
  bool follows = false;  // there is an earlier frame
};

class TemporalAverage {
 public:
  // Averages `picture` with the history, if there is one and the frame continues it.
  void average(const AverageRequest& request, const OpaquePixels& pixels, const std::vector<glm::vec2>& motion,
               Executor& executor, std::vector<glm::vec4>& picture);
  // Makes the last average the history of the next picture.
  void keep();
  void forget() { has_past_ = false; }
  // Replaces the history by a picture, with the largest possible weight.
  void replace(const std::vector<glm::vec4>& picture);

 private:
  class Pass;
  struct Kept {
    uint32_t width = 0, height = 0;
    std::vector<glm::vec4> picture;
    std::vector<glm::vec2> state;  // distance along the axis of the view; pictures in the average
  };
  Kept made_, past_;
  bool has_past_ = false;
  float least_pictures_ = 1.0f;
};

}  // namespace sideray::rt
