// Hands batches of a host's shader from tracing threads to a thread that the host is in (SIDERAY_SHADE_IN_CALLS). Any
// number of threads may call on either side; batches run one at a time.
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

  // Tracing threads call this: it returns when a serving thread has run `batch`. Returns false where the batch did not
  // begin before `cancelled` became true and wake() was called. A deadline does not end the wait: a piece of work that has
  // begun is finished, or a host whose shader is slow would never have an answer.
  bool run(const Batch& batch, const std::atomic<bool>* cancelled);

  // Host's threads call this: it runs what waits now and is not given up.
  void serve();
  // Runs what comes until done() or the time is out; calls done() again after each batch and each wake().
  void serve_until(std::chrono::steady_clock::time_point end, const std::function<bool()>& done);

  // Makes waiting threads check `cancelled`, or done(), again.
  void wake();

 private:
  struct Entry {
    const Batch* batch;
    const std::atomic<bool>* cancelled;
    enum class State { waiting, running, done } state;
    bool is_given_up() const { return cancelled && cancelled->load(); }
  };
  // Takes the first batch that is not given up out of the queue; null = there is none.
  Entry* take_next();
  void run_entry(Entry& entry, std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Entry*> waiting_;
  bool running_ = false;
};

}  // namespace sideray::rt
