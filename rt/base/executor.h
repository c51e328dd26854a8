// Runs numbered pieces of work on its own threads, on all processors of the process; the tracer schedules with it. One
// thread at a time may start a run. It uses TBB, or plain threads if SIDERAY_STD_THREADS is defined, for the thread
// sanitizer.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

namespace sideray::rt {

class Executor {
 public:
  // `threads`: 0 = cpu_count().
  explicit Executor(uint32_t threads);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  uint32_t threads() const { return threads_; }

  // Calls work() so that its parallel TBB code runs on these threads.
  void inside(const std::function<void()>& work);

  using Work = std::function<void(size_t index, uint32_t worker)>;
  // Calls work(index, worker) once for every index below `count` and returns when all are done. `worker` is below
  // threads(), and calls that overlap never share it. Denormals are flushed to zero in every call, so that results do
  // not depend on the calling thread's mode. The first exception is rethrown here. Called from within a run of the same
  // executor, it makes all calls on the calling thread, with that thread's worker number.
  void run(size_t count, const Work& work);
  // Does the same for work that takes less time than to hand it to a thread.
  template <typename Cheap>
  void run_cheap(size_t count, const Cheap& work) {
    constexpr size_t in_part = 16;
    run((count + in_part - 1) / in_part, [&](size_t part, uint32_t worker) {
      for (size_t i = part * in_part; i < std::min((part + 1) * in_part, count); ++i) work(i, worker);
    });
  }

 private:
  void run_on_all(size_t count, const Work& work);

  struct Arena;
  uint32_t threads_;
  std::unique_ptr<Arena> arena_;
};

}  // namespace sideray::rt
