#include "rt/base/cpus.h"

#include <algorithm>
#include <thread>

#if defined(__linux__)
#include <sched.h>
#endif

namespace sideray::rt {

#if defined(__linux__)

namespace {

struct Cpus {
  cpu_set_t set;
  bool known;
};

// With more than the 1024 processors of a cpu_set_t the call fails, and threads keep their affinity.
Cpus cpus_of_this_thread() {
  Cpus cpus{};
  cpus.known = sched_getaffinity(0, sizeof(cpus.set), &cpus.set) == 0;
  return cpus;
}

const Cpus& cpus() {
  static const Cpus at_first = cpus_of_this_thread();
  return at_first;
}

[[maybe_unused]] const Cpus& at_load = cpus();

}  // namespace

uint32_t cpu_count() {
  const int count = cpus().known ? CPU_COUNT(&cpus().set) : static_cast<int>(std::thread::hardware_concurrency());
  return static_cast<uint32_t>(std::max(1, count));
}

void run_on_all_cpus() {
  thread_local bool done = false;
  if (done || !cpus().known) return;
  done = true;
  sched_setaffinity(0, sizeof(cpus().set), &cpus().set);
}

#else

uint32_t cpu_count() {
  return std::max(1u, std::thread::hardware_concurrency());
}

void run_on_all_cpus() {}

#endif

}  // namespace sideray::rt
