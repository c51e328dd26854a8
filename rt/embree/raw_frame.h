// Times what rays cost on this machine without our code. A raw frame is the time of coherent closest hits, 16 at a
// time, through every pixel of a frame, with all triangles of a snapshot in one high-quality scene. Times of different
// machines and scenes can be compared as multiples of it.
#pragma once

#include <cstdint>
#include <string>

#include "model/snapshot.h"
#include "rt/base/executor.h"
#include "rt/base/view.h"

namespace sideray::rt {

struct RawFrame {
  double ms = 0;           // the best of the repeats; 0 = not measured
  uint64_t triangles = 0;  // in the scene; a mesh's triangles count once per instance
  bool flat = false;       // false: the scene keeps instances
  uint64_t hits = 0;       // rays that hit something, where width and height are multiples of 4
};

struct RawFrameRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  uint32_t repeats = 5;    // timed runs, after one that is not timed
  uint64_t most_flat = 0;  // with more triangles than this the scene keeps instances of shared meshes
};

// Builds the scene of opaque and translucent triangles, times it on the executor's threads and frees it. `isa` is as in
// open_device(). Building takes seconds and about 300 bytes a triangle. Throws Failure.
RawFrame time_raw_frame(const model::Snapshot& snapshot, const RawFrameRequest& request, const std::string& isa,
                        Executor& executor);

}  // namespace sideray::rt
