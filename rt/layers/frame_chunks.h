// Cuts the pixels of a frame into chunks, which threads trace one by one. One thread at a time may call it; a run calls
// back on many.
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
  // Gathers the request's pixels and cuts them into chunks. Throws Failure if the request is invalid.
  void gather(const LayerRequest& request, const PixelSelection& selection, Executor& executor);
  // Returns the frame in which the least recently traced of some pixels was traced, 0 = never.
  using LastTurn = std::function<uint32_t(std::span<const PixelRequest>)>;
  // Makes the chunks of a request under a deadline take turns over frames, the least recently traced first. A frame may
  // have time for only one chunk, so the first is cut into parts for several threads.
  void take_turns(const LayerRequest& request, const LastTurn& last_turn, Executor& executor);

  const FramePixels& frame() const { return frame_; }
  size_t count() const { return starts_.size() - 1; }
  std::span<const PixelRequest> chunk(size_t index) const;

  // Traces a chunk on a thread of the executor, and returns whether it was completed.
  using Trace = std::function<TraceEnd(size_t chunk, std::span<const PixelRequest> pixels, uint32_t thread)>;
  // Returns how many pixels of a skipped chunk have no answer.
  using Leave = std::function<uint64_t(std::span<const PixelRequest> pixels, uint32_t thread)>;
  // Calls `trace` for the chunks, under a deadline in their order, until the request is cancelled or late, and `leave`
  // for chunks that are not completed. An empty `leave` leaves all their pixels without an answer. `trace` may be empty
  // if is_over(). Returns whether the frame was cancelled, otherwise complete; counts pixels_late.
  TraceEnd run(const LayerRequest& request, Executor& executor, const Trace& trace, const Leave& leave,
               Counters& counters) const;

 private:
  void cut_first();

  FramePixels frame_;
  std::vector<uint32_t> starts_{0};  // first pixel of each chunk, then the number of pixels
  std::vector<uint32_t> order_;  // the order in which chunks are taken; empty = by number
  size_t first_parts_ = 1;       // number of parts of the first chunk
};

}  // namespace sideray::rt
