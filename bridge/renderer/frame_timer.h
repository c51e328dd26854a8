// Times the stages of a frame by the wall clock: timer queries measure nothing on software drivers. GL thread.
#pragma once

#include <sideray/renderer.h>

#include <array>
#include <chrono>

#include "bridge/renderer/stages.h"
#include "gl/context/functions.h"

namespace sideray::bridge {

class FrameTimer {
 public:
  enum class Mode {
    off,    // stages just run
    staged  // glFinish before and after each stage; times add up over the samples of a frame
  };
  FrameTimer(const gl::Functions& gl, Mode mode) : gl_(gl), mode_(mode) {}

  template <typename Body>
  void stage(sideray_stage stage, Body&& body) {
    if (mode_ == Mode::off) {
      body();
      return;
    }
    gl_.Finish();
    const auto start = std::chrono::steady_clock::now();
    body();
    gl_.Finish();
    add(stage, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  // For stages that the service timed itself.
  void add(sideray_stage stage, double ms) { ms_[stage] += ms; }
  bool staged() const { return mode_ == Mode::staged; }
  double ms(sideray_stage stage) const { return ms_[stage]; }

 private:
  const gl::Functions& gl_;
  Mode mode_;
  std::array<double, stage_count> ms_{};
};

}  // namespace sideray::bridge
