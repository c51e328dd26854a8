// Decides when a frame starts no more rays, and orders its work so that the least important part is left out. Any
// thread may call it.
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

// Pieces of work under a deadline are small, because a piece that has begun is finished.
inline constexpr size_t pixels_in_late_chunk = 64;

inline bool has_deadline(Deadline deadline) {
  return deadline != Deadline::max();
}
inline bool has_passed(Deadline deadline) {
  return has_deadline(deadline) && Deadline::clock::now() >= deadline;
}

// Counts down the pieces of work that may still begin; tests use it in place of a clock.
using PiecesLeft = std::atomic<int64_t>;

// Says until when pieces of work may begin. Preparation alone may exceed the deadline, and then no frame would ever
// have an answer. So pieces may begin for at least `least` after the WorkClock was made.
struct WorkTime {
  Deadline deadline = Deadline::max();
  Deadline::duration least{0};
  size_t least_pieces = 0;  // so many pieces begin in any case
  bool ends_in_time = false;  // a piece does not begin if it is likely to end after the deadline
  PiecesLeft* pieces = nullptr;  // null: the clock decides
};
inline bool is_bounded(const WorkTime& time) {
  return has_deadline(time.deadline) || time.pieces;
}
// Returns whether no further piece of the work may begin.
inline bool is_over(const WorkTime& time) {
  return time.least_pieces == 0 && time.least.count() == 0 && !time.pieces && has_passed(time.deadline);
}

// Limits a part of a frame's work that has begun. Any thread may run pieces.
class WorkClock {
 public:
  explicit WorkClock(const WorkTime& time)
      : time_(time), left_(time.pieces ? std::max(time.pieces->load(), int64_t{0}) : 0) {
    if (has_deadline(time_.deadline)) time_.deadline = std::max(time_.deadline, Deadline::clock::now() + time_.least);
  }
  ~WorkClock() {
    if (time_.pieces) *time_.pieces -= std::min(left_, began_.load());
  }
  WorkClock(const WorkClock&) = delete;
  WorkClock& operator=(const WorkClock&) = delete;

  // Runs a piece, or returns false if there is no time for it. `number` is the piece's place in the order of work: if
  // pieces are counted, the same ones run for any number of threads.
  template <typename Work>
  bool run(size_t number, const Work& work) {
    if (!may_begin(number)) return false;
    ++began_;
    if (!time_.ends_in_time) {
      work();
      return true;
    }
    const Deadline begun = Deadline::clock::now();
    work();
    spent_ += (Deadline::clock::now() - begun).count();
    ++ended_;
    return true;
  }

 private:
  bool may_begin(size_t number) const {
    if (number < time_.least_pieces) return true;
    if (time_.pieces) return static_cast<int64_t>(number) < left_;
    if (!has_deadline(time_.deadline)) return true;
    const int64_t ended = ended_;
    const Deadline::duration usual(ended > 0 ? spent_ / ended : 0);
    return Deadline::clock::now() + usual < time_.deadline;
  }

  WorkTime time_;
  const int64_t left_;
  std::atomic<int64_t> began_{0}, spent_{0}, ended_{0};
};

// Orders chunks of pixels from the middle of the picture outward; chunks whose masks count many surfaces move forward.
// The order is the same in every frame: without history, chunks that took turns would flicker between their ray-traced
// and their raster look. `starts`: each chunk's first pixel, then the total number of pixels.
std::vector<uint32_t> order_of_importance(std::span<const PixelRequest> pixels, std::span<const uint32_t> starts,
                                          uint32_t width, uint32_t height);
// Orders square tiles, given row by row, from the middle outward.
std::vector<uint32_t> order_of_importance(uint32_t tile_columns, uint32_t tile_rows);

// Moves the least recently traced pieces to the front, since the others can show their previous answers; equal ones
// keep their order. `last_turns`: for each piece the number of the frame that last traced it, 0 = none.
void order_by_turns(std::span<const uint32_t> last_turns, std::vector<uint32_t>& order);

}  // namespace sideray::rt
