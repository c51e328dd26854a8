// Tests a host that pins its drawing thread: tracing threads use all processors, and the host stays pinned. The test is
// strict only as the first of a process, as in ctest, since TBB counts processors once.
#if defined(__linux__)
#include <gtest/gtest.h>
#include <sched.h>

#include <chrono>
#include <map>
#include <mutex>
#include <thread>

#include "rt/base/cpus.h"
#include "rt/base/executor.h"

namespace sideray::rt {
namespace {

// Pins the calling thread to the first processor that it may use, as hosts pin the one that draws.
class Pinned {
 public:
  Pinned() {
    sched_getaffinity(0, sizeof(before_), &before_);
    cpu_set_t one{};
    for (size_t cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
      if (CPU_ISSET(cpu, &before_)) CPU_SET(cpu, &one);
    sched_setaffinity(0, sizeof(one), &one);
  }
  ~Pinned() { sched_setaffinity(0, sizeof(before_), &before_); }
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;

 private:
  cpu_set_t before_{};
};

int cpus_of_this_thread() {
  cpu_set_t set{};
  return sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 0;
}

TEST(PinnedHost, IsNotFollowedByTheThreadsThatTrace) {
  const auto all = static_cast<int>(cpu_count());
  if (all < 2) GTEST_SKIP() << "one processor";
  const Pinned pinned;
  ASSERT_EQ(cpus_of_this_thread(), 1);
  Executor executor(0);
  EXPECT_EQ(executor.threads(), cpu_count());
  std::mutex mutex;
  std::map<std::thread::id, int> cpus;
  // Runs until another thread has helped, for at most two seconds.
  for (int round = 0; round < 100 && cpus.size() < 2; ++round)
    executor.run(8 * cpu_count(), [&](size_t, uint32_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const std::lock_guard lock(mutex);
      cpus[std::this_thread::get_id()] = cpus_of_this_thread();
    });
  EXPECT_GE(cpus.size(), 2u) << "the caller works alone";
  for (const auto& [thread, count] : cpus) EXPECT_EQ(count, thread == std::this_thread::get_id() ? 1 : all);
  EXPECT_EQ(cpus_of_this_thread(), 1) << "the caller is pinned no more";
}

}  // namespace
}  // namespace sideray::rt
#endif
