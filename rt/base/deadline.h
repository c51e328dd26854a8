// Decides when a frame gives up the rays that have not begun, and orders its work so that what matters least is given
// up. Any thread may call it.
#pragma once

#include <algorithm>
#include <atomic>
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

// Counts down the pieces of work that may begin, in place of a clock, for tests.
using PiecesLeft = std::atomic<int64_t>;

// Says until when pieces of work may begin. What prepares them may take longer than the whole time allowed; were none
// traced then, no frame would ever have an answer. So they have `least` from their first on.
struct WorkTime {
  Deadline deadline = Deadline::max();
  Deadline::duration least{0};
  PiecesLeft* pieces = nullptr;  // null: the clock decides
};

// Stands for the work of a frame that has begun; any thread may ask.
class WorkClock {
 public:
  explicit WorkClock(const WorkTime& time) : pieces_(time.pieces), deadline_(time.deadline) {
    if (has_deadline(deadline_)) deadline_ = std::max(deadline_, Deadline::clock::now() + time.least);
  }
  // Returns whether the next piece must not begin. Asked once for each.
  bool is_over() const { return pieces_ ? pieces_->fetch_sub(1) <= 0 : has_passed(deadline_); }

 private:
  PiecesLeft* pieces_;
  Deadline deadline_;
};

// Orders chunks of pixels from the middle of the picture outward, those whose masks count many surfaces earlier. The
// order is the same in every frame, whatever was given up in the last one: where nothing is kept of frames before, chunks
// that took turns would flicker between their ray-traced and their raster look.
// `starts`: each chunk's first pixel, and behind the last.
std::vector<uint32_t> order_of_importance(std::span<const PixelRequest> pixels, std::span<const uint32_t> starts,
                                          uint32_t width, uint32_t height);
// Orders square tiles, row by row, in the same way.
std::vector<uint32_t> order_of_importance(uint32_t tile_columns, uint32_t tile_rows);

// Brings the least recently traced pieces first, since the others show their previous answers; equal ones stay in their
// order. `last_turns`: of each piece the number of the frame in which it was traced last, 0 = never.
void order_by_turns(std::span<const uint32_t> last_turns, std::vector<uint32_t>& order);

}  // namespace sideray::rt
