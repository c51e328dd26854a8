// Traces fragments that a reduced rate left without an answer, as any host could: docs/embedding.md. GL thread.
#pragma once

#include "bridge/raster/raster_parts.h"

namespace sideray::bridge {

// Holds the frame that the second wave adds layers to, and the pass whose fragments look them up.
struct FirstWave {
  sideray_ticket ticket;
  gl::Translucency pass;
};

// Returns the counters that the wave adds to its frame's statistics.
rt::Counters trace_second_wave(const RasterParts& parts, const PictureJob& job, const FramePosition& position,
                               const FirstWave& first, FrameTimer& timer);

}  // namespace sideray::bridge
