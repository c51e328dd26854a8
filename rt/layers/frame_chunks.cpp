#include "rt/layers/frame_chunks.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "rt/base/deadline.h"

namespace sideray::rt {
namespace {

// Returns the pixels in a chunk: enough for full batches of shading, but fewer in a small frame, where most threads
// would wait for the last chunks. A packet is 16 pixels. It does not depend on the thread count, so packets and bits
// are the same.
size_t pixels_in_chunk(size_t pixels) {
  constexpr size_t least = 256, most = 1024, wanted_chunks = 64, packet = 16;
  return std::clamp(pixels / wanted_chunks / packet * packet, least, most);
}

// Returns the first pixels of chunks. `in_blocks`: chunks hold whole blocks, so that a block is traced in one turn.
std::vector<uint32_t> cut(const std::vector<PixelRequest>& pixels, size_t most, bool in_blocks) {
  const auto same_block = [&](size_t a, size_t b) {
    return pixels[a].x / traced_block == pixels[b].x / traced_block && pixels[a].y / traced_block == pixels[b].y / traced_block;
  };
  std::vector<uint32_t> starts{0};
  for (size_t first = 0; first < pixels.size();) {
    size_t end = std::min(first + most, pixels.size());
    if (in_blocks && end < pixels.size())
      while (end > first + 1 && same_block(end - 1, end)) --end;
    first = end;
    starts.push_back(static_cast<uint32_t>(end));
  }
  return starts;
}

// Calls work(first chunk, end, thread) for ranges of chunks, since work that traces nothing costs less than a call.
template <typename Work>
void for_parts(size_t chunks, Executor& executor, const Work& work) {
  constexpr size_t chunks_in_part = 64;
  executor.run((chunks + chunks_in_part - 1) / chunks_in_part, [&](size_t part, uint32_t thread) {
    work(part * chunks_in_part, std::min((part + 1) * chunks_in_part, chunks), thread);
  });
}

}  // namespace

void FrameChunks::gather(const LayerRequest& request, const PixelSelection& selection, Executor& executor) {
  gather_pixels(request, selection, executor, frame_);
  order_.clear();
  first_parts_ = 1;
  const bool bounded = is_bounded(request.work);
  starts_ = cut(frame_.pixels, bounded ? pixels_in_late_chunk : pixels_in_chunk(frame_.pixels.size()), bounded);
  if (bounded && !is_over(request.work))
    order_ = order_of_importance(frame_.pixels, starts_, request.width, request.height);
}

void FrameChunks::take_turns(const LayerRequest& request, const LastTurn& last_turn, Executor& executor) {
  if (is_over(request.work)) return;
  std::vector<uint32_t> turns(count());
  for_parts(turns.size(), executor, [&](size_t first, size_t end, uint32_t) {
    for (size_t i = first; i < end; ++i) turns[i] = last_turn(chunk(i));
  });
  order_by_turns(turns, order_);
  if (request.work.ends_in_time && !order_.empty()) cut_first();
}

void FrameChunks::cut_first() {
  constexpr uint32_t part = 8;  // pixels
  const uint32_t first = order_.front(), begin = starts_[first], end = starts_[first + 1];
  std::vector<uint32_t> cuts;
  for (uint32_t pixel = begin + part; pixel < end; pixel += part) cuts.push_back(pixel);
  starts_.insert(starts_.begin() + first + 1, cuts.begin(), cuts.end());
  const auto more = static_cast<uint32_t>(cuts.size());
  for (uint32_t& chunk : order_)
    if (chunk > first) chunk += more;
  std::vector<uint32_t> parts(more);
  std::iota(parts.begin(), parts.end(), first + 1);
  order_.insert(order_.begin() + 1, parts.begin(), parts.end());
  first_parts_ = 1 + more;
}

std::span<const PixelRequest> FrameChunks::chunk(size_t index) const {
  return std::span(frame_.pixels).subspan(starts_[index], starts_[index + 1] - starts_[index]);
}

TraceEnd FrameChunks::run(const LayerRequest& request, Executor& executor, const Trace& trace, const Leave& leave,
                          Counters& counters) const {
  std::atomic<uint64_t> late{0};
  if (is_over(request.work)) {
    for_parts(count(), executor, [&](size_t first, size_t end, uint32_t thread) {
      uint64_t left = 0;
      for (size_t i = first; i < end; ++i) left += leave ? leave(chunk(i), thread) : chunk(i).size();
      late += left;
    });
    counters.pixels_late += late;
    return request.cancelled && request.cancelled->load() ? TraceEnd::cancelled : TraceEnd::complete;
  }
  std::atomic<bool> cancelled{false};
  WorkTime work = request.work;
  if (first_parts_ > 1) {  // one chunk of glass that bends light may take longer than all other jobs
    work.least_pieces += work.least_pieces > 0 ? first_parts_ - 1 : 0;
    work.least = {};
  }
  WorkClock clock(work);
  std::atomic<size_t> next{0};
  executor.run(count(), [&](size_t numbered, uint32_t thread) {
    if (cancelled || (request.cancelled && request.cancelled->load())) {
      cancelled = true;
      return;
    }
    // Without an order, threads get ranges of numbers; with one, each free thread takes the next chunk.
    const size_t number = order_.empty() ? numbered : next++, index = order_.empty() ? numbered : order_[number];
    const std::span<const PixelRequest> pixels = chunk(index);
    TraceEnd end = TraceEnd::late;
    clock.run(number, [&] { end = trace(index, pixels, thread); });
    if (end == TraceEnd::cancelled) cancelled = true;
    if (end != TraceEnd::complete) late += leave ? leave(pixels, thread) : pixels.size();
  });
  counters.pixels_late += late;
  return cancelled ? TraceEnd::cancelled : TraceEnd::complete;
}

}  // namespace sideray::rt
