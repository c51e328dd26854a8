// Draws one frame of a picture: the opaque surfaces, what rays find, then what is translucent. GL thread.
#pragma once

#include "bridge/renderer/picture_job.h"

namespace sideray::bridge {

struct FrameCounters {
  rt::Counters trace;
  gl::FragmentCounts fragments;  // where they are counted
  uint64_t duplicated = 0;       // layers that are there twice; with sideray_translucency_options::check
  void operator+=(const FrameCounters& frame);
};

// Whether fragments are only drawn, or counted too and, where options say so, checked: an extra pass.
enum class Fragments { drawn, counted };

FrameCounters draw_frame(PictureJob& job, const FramePosition& position, FrameTimer& timer, Fragments fragments);

// Fills the part of the statistics that frames count.
void state_counters(const FrameCounters& counters, sideray_render_stats& stats);

}  // namespace sideray::bridge
