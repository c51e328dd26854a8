// Whose turn it is to use a tracer: a mutex that a thread need not wait for any longer once its frame is cancelled. A
// service's worker may hold it while it waits for the host. Any thread.
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
  // False, and not locked, where `cancelled` is true, or becomes so and wake() is called.
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
