// Runs the worker thread that traces the jobs of frames one by one, in the order in which they are pushed. All calls
// come from the GL thread.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

#include "bridge/service/service_frame.h"

namespace sideray::bridge {

class TraceQueue {
 public:
  // Calls `trace` on the worker thread with a frame and the index of its job, and `traced` after each.
  TraceQueue(std::function<void(ServiceFrame&, size_t)> trace, std::function<void()> traced);
  // Joins the worker, which first finishes all pushed jobs: cancel their frames before.
  ~TraceQueue();
  TraceQueue(const TraceQueue&) = delete;
  TraceQueue& operator=(const TraceQueue&) = delete;

  // Queues a job; only the worker may touch its run until is_traced().
  void push(ServiceFrame& frame, size_t job);
  bool is_traced(const JobRun& run) const;
  // Blocks until all pushed jobs are traced.
  void wait_until_idle();

 private:
  struct Task {
    ServiceFrame* frame;
    size_t job;
  };
  void work(std::stop_token stop);

  std::function<void(ServiceFrame&, size_t)> trace_;
  std::function<void()> traced_;
  mutable std::mutex mutex_;
  std::condition_variable_any ready_, idle_;
  std::deque<Task> tasks_;  // guarded by mutex_, like the next
  size_t unfinished_ = 0;
  std::jthread worker_;
};

}  // namespace sideray::bridge
