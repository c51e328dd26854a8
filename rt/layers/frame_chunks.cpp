#include "rt/layers/frame_chunks.h"

#include <algorithm>
#include <atomic>

#include "rt/base/deadline.h"

namespace sideray::rt {
namespace {

// So many that shading has full batches, or fewer where a frame has few: then the last of them would keep most threads
// waiting. A packet is 16 pixels. Whatever the thread count: the same packets, the same bits.
size_t pixels_in_chunk(size_t pixels) {
  constexpr size_t least = 256, most = 1024, wanted_chunks = 64, packet = 16;
  return std::clamp(pixels / wanted_chunks / packet * packet, least, most);
}

}  // namespace

void FrameChunks::gather(const LayerRequest& request, const PixelSelection& selection, Executor& executor) {
  gather_pixels(request, selection, executor, frame_);
  order_.clear();
  chunk_pixels_ = pixels_in_chunk(frame_.pixels.size());
  if (!has_deadline(request.deadline)) return;
  chunk_pixels_ = pixels_in_late_chunk;
  order_ = order_of_importance(frame_.pixels, chunk_pixels_, request.width, request.height);
}

std::span<const PixelRequest> FrameChunks::chunk(size_t index) const {
  const size_t first = index * chunk_pixels_;
  return std::span(frame_.pixels).subspan(first, std::min(chunk_pixels_, frame_.pixels.size() - first));
}

TraceEnd FrameChunks::run(const LayerRequest& request, Executor& executor, const Trace& trace,
                          Counters& counters) const {
  std::atomic<bool> cancelled{false};
  std::atomic<uint64_t> late{0};
  executor.run(count(), [&](size_t place, uint32_t thread) {
    if (cancelled || (request.cancelled && request.cancelled->load())) {
      cancelled = true;
      return;
    }
    const size_t index = order_.empty() ? place : order_[place];
    const std::span<const PixelRequest> pixels = chunk(index);
    const TraceEnd end = has_passed(request.deadline) ? TraceEnd::late : trace(index, pixels, thread);
    if (end == TraceEnd::cancelled) cancelled = true;
    if (end != TraceEnd::complete) late += pixels.size();
  });
  counters.pixels_late += late;
  return cancelled ? TraceEnd::cancelled : TraceEnd::complete;
}

}  // namespace sideray::rt
