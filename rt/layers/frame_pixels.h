// Finds the traced pixels of a frame and orders them: blocks of 16 inside 32x32 tiles, so that a packet's rays are
// neighbours. Any thread may call it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/base/pixels.h"
#include "rt/layers/layer_request.h"

namespace sideray::rt {

inline constexpr uint32_t traced_block = 4;  // traced pixels along each side of a block

// Describes which pixels a rate traces: one of each cell of cell_width x cell_height, the one with the smallest x and
// y. Checkerboard cells are two pixels wide and shifted by one pixel in odd rows.
struct RatePattern {
  uint32_t cell_width = 1, cell_height = 1;
  bool staggered = false;
  bool traces(uint32_t x, uint32_t y) const {
    return (x + (staggered ? y : 0)) % cell_width == 0 && y % cell_height == 0;
  }
};
RatePattern pattern_of(sideray_cache_rate rate);

// Says which masked pixels are gathered.
struct PixelSelection {
  RatePattern pattern;
  uint32_t requested_bits = 0;  // CacheRequest::requested_bits
  bool counted = true;          // true: the mask's values count surfaces; false: each pixel requests as many as
                                // possible
};
PixelSelection selection_of(const CacheRequest& request);

// Refills `frame`. Throws Failure if the request is invalid.
void gather_pixels(const LayerRequest& request, const PixelSelection& selection, Executor& executor,
                   FramePixels& frame);

// Returns all pixels of a picture; each requests all of its surfaces.
FramePixels every_pixel(uint32_t width, uint32_t height, Executor& executor);

// Calls `trace` in all threads, with at most `most` of the frame's pixels and the number of the thread.
template <typename Trace>
void trace_in_chunks(const FramePixels& frame, size_t most, Executor& executor, const Trace& trace) {
  const std::span<const PixelRequest> pixels = frame.pixels;
  executor.run((pixels.size() + most - 1) / most, [&](size_t chunk, uint32_t thread) {
    const size_t first = chunk * most;
    trace(pixels.subspan(first, std::min(most, pixels.size() - first)), thread);
  });
}

}  // namespace sideray::rt
