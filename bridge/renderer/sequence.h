// What a renderer keeps from one picture of a sequence to the next. GL thread.
#pragma once

#include <glm/glm.hpp>

#include "bridge/plan/frame_plan.h"
#include "gl/passes/pass_inputs.h"
#include "gl/rasterizer.h"

namespace sideray::bridge {

class Sequence {
 public:
  explicit Sequence(gl::Rasterizer& rasterizer) : rasterizer_(rasterizer) {}

  // A picture begins: where it continues none, the pictures before it are forgotten.
  void begin(const FramePlan& plan, const RenderOptions& options);
  // The picture is done, and the next one may continue it. After a failure no picture can.
  void keep(const FramePlan& plan, gl::FrameBefore frame);
  // Another scene is drawn from now on.
  void forget() { before_ = {}; }

  const gl::FrameBefore& before() const { return before_; }
  // Where the picture's position of number `sample` lies, in pixels from the pixel's centre.
  glm::vec2 jitter(const FramePlan& plan, uint32_t sample) const;

 private:
  gl::Rasterizer& rasterizer_;
  gl::FrameBefore before_;
  glm::uvec2 size_before_{0};
  uint32_t averaged_ = 0;  // pictures in a row before this one
};

}  // namespace sideray::bridge
