// Decides when a frame gives up the rays that have not begun, and orders its work so that what matters least is given
// up. Any thread may call it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/pixels.h"

namespace sideray::rt {

using Deadline = std::chrono::steady_clock::time_point;  // max() = none

// Pieces of work under a deadline are small, since one that has begun is finished.
inline constexpr size_t pixels_in_late_chunk = 128;

inline bool has_deadline(Deadline deadline) {
  return deadline != Deadline::max();
}
inline bool has_passed(Deadline deadline) {
  return has_deadline(deadline) && Deadline::clock::now() >= deadline;
}

// Orders chunks of pixels from the middle of the picture outward, those whose masks count many surfaces earlier. The
// order is the same in every frame, whatever was given up in the last one: if chunks took turns, they would flicker
// between their ray-traced and their raster look.
std::vector<uint32_t> order_of_importance(std::span<const PixelRequest> pixels, size_t pixels_in_chunk, uint32_t width,
                                          uint32_t height);
// Orders square tiles, row by row, in the same way.
std::vector<uint32_t> order_of_importance(uint32_t tile_columns, uint32_t tile_rows);

}  // namespace sideray::rt
