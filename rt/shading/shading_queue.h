// Hands batches of a host's shader from tracing threads to a thread that the host is in (SIDERAY_SHADE_IN_CALLS). Any
// number of threads on either side; batches run one at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>

#include "rt/base/deadline.h"

namespace sideray::rt {

class ShadingQueue {
 public:
  using Batch = std::function<void()>;

  // Tracing threads: returns when some serving thread has run `batch`. False where it did not begin before the
  // deadline, or before `cancelled` became true and wake() was called.
  bool run(const Batch& batch, const std::atomic<bool>* cancelled, Deadline deadline);

  // Host's threads: runs what waits now and is not given up.
  void serve();
  // Runs what comes until done() or the time is out; done() is asked again after each batch and each wake().
  void serve_until(std::chrono::steady_clock::time_point end, const std::function<bool()>& done);

  // Whoever waits looks at `cancelled`, or done(), again.
  void wake();

 private:
  struct Entry {
    const Batch* batch;
    const std::atomic<bool>* cancelled;
    Deadline deadline;
    enum class State { waiting, running, done } state;
    bool is_given_up() const { return (cancelled && cancelled->load()) || has_passed(deadline); }
  };
  // The first that nobody has given up, out of the queue; null = there is none.
  Entry* take_next();
  void run_entry(Entry& entry, std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Entry*> waiting_;
  bool running_ = false;
};

}  // namespace sideray::rt
