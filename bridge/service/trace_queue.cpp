#include "bridge/service/trace_queue.h"

#include <utility>

#include "rt/base/cpus.h"

namespace sideray::bridge {

TraceQueue::TraceQueue(std::function<void(ServiceFrame&, size_t)> trace, std::function<void()> traced)
    : trace_(std::move(trace)), traced_(std::move(traced)) {
  worker_ = std::jthread([this](std::stop_token stop) { work(stop); });
}

TraceQueue::~TraceQueue() {
  worker_.request_stop();
  worker_.join();
}

void TraceQueue::push(ServiceFrame& frame, size_t job) {
  const std::lock_guard lock(mutex_);
  JobRun& run = frame.runs[job];
  run.trace_finished = false;
  run.failure = nullptr;
  tasks_.push_back({&frame, job});
  ++unfinished_;
  ready_.notify_one();
}

bool TraceQueue::is_traced(const JobRun& run) const {
  const std::lock_guard lock(mutex_);
  return run.trace_finished;
}

void TraceQueue::wait_until_idle() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [&] { return unfinished_ == 0; });
}

void TraceQueue::work(std::stop_token stop) {
  rt::run_on_all_cpus();
  for (;;) {
    Task task{};
    {
      std::unique_lock lock(mutex_);
      if (!ready_.wait(lock, stop, [&] { return !tasks_.empty(); })) return;
      task = tasks_.front();
      tasks_.pop_front();
    }
    std::exception_ptr failure;
    try {
      trace_(*task.frame, task.job);
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      JobRun& run = task.frame->runs[task.job];
      run.failure = failure;
      run.trace_finished = true;
      --unfinished_;
      idle_.notify_all();
    }
    traced_();
  }
}

}  // namespace sideray::bridge
