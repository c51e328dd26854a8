#include "viewer/base/watchdog.h"

#include <utility>

namespace sideray::viewer {
namespace {

constexpr uint32_t ticks_of_limit = 20;

}  // namespace

Watchdog::Watchdog(std::chrono::milliseconds limit, std::function<void()> expire)
    : thread_([this, limit, expire = std::move(expire)] { run(limit, expire); }) {}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void Watchdog::change(int watches) {
  const std::lock_guard lock(mutex_);
  watches_ += watches;
  ticks_ = 0;
  changed_.notify_one();
}

// Counts ticks of its own instead of asking a clock: a clock goes on while the whole program is stopped (SIGSTOP, a
// debugger), and the watched call then is not late.
void Watchdog::run(std::chrono::milliseconds limit, const std::function<void()>& expire) {
  std::unique_lock lock(mutex_);
  while (!stops_) {
    if (watches_ == 0) {
      changed_.wait(lock);
    } else if (changed_.wait_for(lock, limit / ticks_of_limit) == std::cv_status::timeout && ++ticks_ == ticks_of_limit) {
      expire();  // under the lock: the watched thread cannot go on meanwhile
    }
  }
}

}  // namespace sideray::viewer
