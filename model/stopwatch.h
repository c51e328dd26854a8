// Measures wall-clock time. Any thread may use its own.
#pragma once

#include <chrono>

namespace sideray {

class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;

  Clock::time_point start() const { return start_; }
  // Returns the time since the start.
  double ms() const { return std::chrono::duration<double, std::milli>(Clock::now() - start_).count(); }

 private:
  Clock::time_point start_ = Clock::now();
};

}  // namespace sideray
