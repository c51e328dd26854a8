// Times what rays cost on this machine with nothing of ours around them. A raw frame is the time of coherent closest
// hits, 16 at a time, through every pixel of a frame, on all triangles of a snapshot in one high-quality scene: a measure
// that times of different machines and scenes can be held against.
#pragma once

#include <cstdint>
#include <string>

#include "model/snapshot.h"
#include "rt/base/executor.h"
#include "rt/base/view.h"

namespace sideray::rt {

struct RawFrame {
  double ms = 0;           // the best of the repeats; 0 = not measured
  uint64_t triangles = 0;  // in the scene; those of instances count each time
  bool flat = false;       // false: instances were left as instances
  uint64_t hits = 0;       // rays that hit something, where width and height are multiples of 4
};

struct RawFrameRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  uint32_t repeats = 5;    // timed, after one that is not
  uint64_t most_flat = 0;  // with more triangles the instances are left as instances of shared meshes
};

// Builds the scene, opaque and translucent triangles alike, times it on the executor's threads and drops it again. `isa`
// is as in open_device(). Building takes as long as seconds, and about 300 bytes a triangle. Throws Failure.
RawFrame time_raw_frame(const model::Snapshot& snapshot, const RawFrameRequest& request, const std::string& isa,
                        Executor& executor);

}  // namespace sideray::rt
