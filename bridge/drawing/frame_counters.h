// Counts the work of one frame of a picture. Plain values; any thread.
#pragma once

#include <sideray/renderer.h>

#include <cstdint>

#include "gl/passes/pass_inputs.h"
#include "rt/base/counters.h"

namespace sideray::bridge {

struct FrameCounters {
  rt::Counters trace;
  gl::FragmentCounts fragments;  // only where they are counted
  uint64_t duplicated = 0;       // layers that occur twice; with sideray_translucency_options::check
  void operator+=(const FrameCounters& frame);
};

// Fills the counters of the statistics.
void state_counters(const FrameCounters& counters, sideray_render_stats& stats);

}  // namespace sideray::bridge
