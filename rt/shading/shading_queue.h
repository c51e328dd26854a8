// Passes batches of a host's shader from tracing threads to a thread on which the host is calling the library
// (SIDERAY_SHADE_IN_CALLS). Any number of threads may call on either side; batches run one at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>

namespace sideray::rt {

class ShadingQueue {
 public:
  using Batch = std::function<void()>;

  // Called by tracing threads: returns when a serving thread has run `batch`. Returns false if `cancelled` became true
  // and wake() was called before the batch began. A deadline does not end the wait: a piece of work that has begun is
  // finished, because otherwise a slow shader would never produce an answer.
  bool run(const Batch& batch, const std::atomic<bool>* cancelled);

  // Called by the host's threads: runs all waiting batches that are not cancelled.
  void serve();
  // Runs batches until done() or the end of the time; calls done() again after each batch and each wake().
  void serve_until(std::chrono::steady_clock::time_point end, const std::function<bool()>& done);

  // Makes waiting threads check `cancelled` or done() again.
  void wake();

 private:
  struct Entry {
    const Batch* batch;
    const std::atomic<bool>* cancelled;
    enum class State { waiting, running, done } state;
    bool is_given_up() const { return cancelled && cancelled->load(); }
  };
  // Removes the first batch that is not cancelled from the queue; null = there is none.
  Entry* take_next();
  void run_entry(Entry& entry, std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Entry*> waiting_;
  bool running_ = false;
};

}  // namespace sideray::rt
