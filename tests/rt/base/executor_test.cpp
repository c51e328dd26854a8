// A tracer's number of threads is its own: the rest of the process keeps all of them.
#include "rt/base/executor.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <array>
#include <atomic>
#include <thread>

#include "rt/tracer.h"

namespace sideray::rt {
namespace {

size_t process_limit() {
  return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
}

TEST(Executor, ATracerDoesNotLimitTheProcess) {
  const size_t before = process_limit();
  const Tracer one({.threads = 1, .isa = ""});
  EXPECT_EQ(process_limit(), before);
}

#if !defined(SIDERAY_STD_THREADS)  // there the executor has threads of its own
TEST(Executor, WhatRunsInsideHasItsThreads) {
  Executor executor(3);
  int threads = 0;
  executor.inside([&] { threads = tbb::this_task_arena::max_concurrency(); });
  EXPECT_EQ(threads, 3);
}
#endif

// Frames that are drawn side by side run their parts on their own threads.
TEST(Executor, ARunInARunStaysOnItsThread) {
  Executor executor(3);
  std::array<std::atomic<int>, 3> busy{};
  std::atomic<int> wrong{0}, done{0};
  executor.run(20, [&](size_t, uint32_t worker) {
    const std::thread::id thread = std::this_thread::get_id();
    if (busy[worker]++ != 0) ++wrong;
    executor.run(5, [&](size_t, uint32_t inside) {
      if (inside != worker || std::this_thread::get_id() != thread || busy[worker] != 1) ++wrong;
      ++done;
    });
    --busy[worker];
  });
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(done, 100);
}

}  // namespace
}  // namespace sideray::rt
