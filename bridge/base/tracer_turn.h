// Locks a tracer for one user: a mutex whose waiting thread returns once its frame is cancelled. A service's worker may
// hold it while it waits for the host. Any thread.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

namespace sideray::bridge {

class TracerTurn {
 public:
  void lock() {
    std::unique_lock held(mutex_);
    given_.wait(held, [&] { return !taken_; });
    taken_ = true;
  }
  // Returns false, without the lock, where `cancelled` is true or becomes true before wake() is called.
  bool lock_unless(const std::atomic<bool>& cancelled) {
    std::unique_lock held(mutex_);
    given_.wait(held, [&] { return !taken_ || cancelled; });
    if (cancelled) return false;
    taken_ = true;
    return true;
  }
  bool try_lock() {
    const std::lock_guard held(mutex_);
    if (taken_) return false;
    return taken_ = true;
  }
  void unlock() {
    const std::lock_guard held(mutex_);
    taken_ = false;
    given_.notify_all();
  }
  void wake() {
    const std::lock_guard held(mutex_);
    given_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable given_;
  bool taken_ = false;
};

}  // namespace sideray::bridge
