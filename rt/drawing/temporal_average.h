// Averages the pictures of a sequence over time, as shaders/light/raster_temporal.frag.glsl does, and stores the last
// average. Row 0 of pixels is the bottom row. One call at a time.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "rt/base/executor.h"
#include "rt/drawing/opaque_pixels.h"

namespace sideray::rt {

struct AverageRequest {
  TraceView view;  // of the frame
  // Rows of matrices: the dot product with a clip-space position of this frame is the distance along the view axis
  // times `share`, for this frame's view and for the previous one.
  glm::dvec4 distance_now{0.0}, distance_before{0.0}, share{0.0};
  bool follows = false;  // there is an earlier frame
};

class TemporalAverage {
 public:
  // Averages `picture` with the history, if there is one that the frame continues.
  void average(const AverageRequest& request, const OpaquePixels& pixels, const std::vector<glm::vec2>& motion,
               Executor& executor, std::vector<glm::vec4>& picture);
  // Makes the last average the history of the next picture.
  void keep();
  void forget() { has_past_ = false; }
  // Replaces the history by a picture with the largest possible weight.
  void replace(const std::vector<glm::vec4>& picture);

 private:
  class Pass;
  struct Kept {
    uint32_t width = 0, height = 0;
    std::vector<glm::vec4> picture;
    std::vector<glm::vec2> state;  // distance along the view axis; number of averaged pictures
  };
  Kept made_, past_;
  bool has_past_ = false;
  float least_pictures_ = 1.0f;
};

}  // namespace sideray::rt
