// Times a frame's stages by the wall clock: timer queries measure nothing on software drivers. The backend's thread.
#pragma once

#include <sideray/renderer.h>

#include <array>

#include "bridge/drawing/backend.h"
#include "bridge/picture/stages.h"
#include "model/stopwatch.h"
#include "rt/base/counters.h"

namespace sideray::bridge {

class FrameTimer {
 public:
  enum class Mode {
    off,    // stages just run
    staged  // each stage first waits for what was drawn before; times add up over the samples of a frame
  };
  FrameTimer(Backend& backend, Mode mode) : backend_(backend), mode_(mode) {}

  template <typename Body>
  void stage(sideray_stage stage, Body&& body) {
    if (mode_ == Mode::off) {
      body();
      return;
    }
    backend_.finish();
    const Stopwatch watch;
    body();
    backend_.finish();
    ms_[stage] += watch.ms();
  }
  // Adds the stages that the service timed.
  void add(const rt::Counters& trace) {
    ms_[SIDERAY_STAGE_READBACK] += trace.readback_ms;
    ms_[SIDERAY_STAGE_TRACE] += trace.trace_ms;
    ms_[SIDERAY_STAGE_TRACE_SHADOW] += trace.trace_shadow_ms;
    ms_[SIDERAY_STAGE_TRACE_AO] += trace.trace_ao_ms;
    ms_[SIDERAY_STAGE_DENOISE] += trace.denoise_ms;
    ms_[SIDERAY_STAGE_UPLOAD] += trace.upload_ms;
  }
  bool staged() const { return mode_ == Mode::staged; }
  double ms(sideray_stage stage) const { return ms_[stage]; }

 private:
  Backend& backend_;
  Mode mode_;
  std::array<double, stage_count> ms_{};
};

}  // namespace sideray::bridge
