// Decides when no more rays of a frame begin, and orders its work so that what matters least is left out. Any thread
// may call it.
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
inline constexpr size_t pixels_in_late_chunk = 64;

inline bool has_deadline(Deadline deadline) {
  return deadline != Deadline::max();
}
inline bool has_passed(Deadline deadline) {
  return has_deadline(deadline) && Deadline::clock::now() >= deadline;
}

// Counts down the pieces of work that may begin, in place of a clock, for tests.
using PiecesLeft = std::atomic<int64_t>;

// Says until when pieces of work may begin. Preparation alone may exceed the deadline, and then no frame would ever
// have an answer. So pieces may begin for at least `least`, counted from the first one.
struct WorkTime {
  Deadline deadline = Deadline::max();
  Deadline::duration least{0};
  size_t least_pieces = 0;  // this many begin in any case
  bool ends_in_time = false;  // a piece that is not likely to end before the deadline does not begin
  PiecesLeft* pieces = nullptr;  // null: the clock decides
};
inline bool is_bounded(const WorkTime& time) {
  return has_deadline(time.deadline) || time.pieces;
}
// Returns whether no piece of it begins any more.
inline bool is_over(const WorkTime& time) {
  return time.least_pieces == 0 && time.least.count() == 0 && !time.pieces && has_passed(time.deadline);
}

// Stands for a part of a frame's work that has begun. Any thread may run pieces.
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

  // Runs a piece, or returns false where there is no time for it. `number`: in the order in which pieces are taken, so
  // that the same pieces run for any number of threads where pieces are counted.
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

// Orders chunks of pixels from the middle of the picture outward, those whose masks count many surfaces earlier. The
// order is the same in every frame, whatever the last one left out: without history, chunks that took turns would
// flicker between their ray-traced and their raster look. `starts`: each chunk's first pixel, and behind the last.
std::vector<uint32_t> order_of_importance(std::span<const PixelRequest> pixels, std::span<const uint32_t> starts,
                                          uint32_t width, uint32_t height);
// Orders square tiles, row by row, in the same way.
std::vector<uint32_t> order_of_importance(uint32_t tile_columns, uint32_t tile_rows);

// Brings the least recently traced pieces first, since the others show their previous answers; equal ones stay in their
// order. `last_turns`: of each piece the number of the frame in which it was traced last, 0 = never.
void order_by_turns(std::span<const uint32_t> last_turns, std::vector<uint32_t>& order);

}  // namespace sideray::rt
