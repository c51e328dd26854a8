// The pixels of a frame in chunks, which threads trace one by one. One thread at a time; the chunks of a run go to
// many.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "rt/base/counters.h"
#include "rt/base/executor.h"
#include "rt/base/pixels.h"
#include "rt/base/trace_end.h"
#include "rt/layers/frame_pixels.h"
#include "rt/layers/layer_request.h"

namespace sideray::rt {

class FrameChunks {
 public:
  // Gathers the request's pixels and cuts them into chunks. Throws Failure where the request makes no sense.
  void gather(const LayerRequest& request, const PixelSelection& selection, Executor& executor);

  const FramePixels& frame() const { return frame_; }
  size_t count() const { return (frame_.pixels.size() + chunk_pixels_ - 1) / chunk_pixels_; }

  // Traces a chunk on a thread of the executor, and says whether it came to the end of it.
  using Trace = std::function<TraceEnd(size_t chunk, std::span<const PixelRequest> pixels, uint32_t thread)>;
  // Calls `trace` for the chunks, under a deadline the most important first, until the request is cancelled or late.
  // Returns whether the frame was cancelled, otherwise complete; counts pixels_late.
  TraceEnd run(const LayerRequest& request, Executor& executor, const Trace& trace, Counters& counters) const;

 private:
  std::span<const PixelRequest> chunk(size_t index) const;

  FramePixels frame_;
  size_t chunk_pixels_ = 1;
  std::vector<uint32_t> order_;  // in which chunks are taken; empty = as they are numbered
};

}  // namespace sideray::rt
