#include "rt/base/executor.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "rt/base/cpus.h"
#include "rt/base/float_mode.h"

#if !defined(SIDERAY_STD_THREADS)
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>
#endif

namespace sideray::rt {
namespace {

uint32_t thread_count(uint32_t wanted) {
  return wanted ? wanted : cpu_count();
}

// Names the executor that this thread works for at the moment, and its worker number there.
struct Running {
  const Executor* executor = nullptr;
  uint32_t worker = 0;
};
thread_local Running running;

// Sets `running` for this thread, and flushes its denormals, for as long as it lives.
class Works {
 public:
  Works(const Executor* executor, uint32_t worker) : before_(std::exchange(running, {executor, worker})) {}
  ~Works() { running = before_; }
  Works(const Works&) = delete;
  Works& operator=(const Works&) = delete;

 private:
  const Running before_;
  const FlushDenormals flush_;
};

}  // namespace

void Executor::run(size_t count, const Work& work) {
  if (running.executor != this) return run_on_all(count, work);
  const FlushDenormals flush;
  for (size_t i = 0; i < count; ++i) work(i, running.worker);
}

#if defined(SIDERAY_STD_THREADS)

struct Executor::Arena {
  static std::unique_ptr<Arena> take(uint32_t) { return std::make_unique<Arena>(); }
  static void give_back(std::unique_ptr<Arena>, uint32_t) {}
};

void Executor::inside(const std::function<void()>& work) {
  work();
}

void Executor::run_on_all(size_t count, const Work& work) {
  std::atomic<size_t> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto loop = [&](uint32_t worker) {
    const Works works(this, worker);
    for (size_t i = next++; i < count; i = next++) try {
        work(i, worker);
      } catch (...) {
        const std::lock_guard lock(error_mutex);
        if (!error) error = std::current_exception();
      }
  };
  std::vector<std::jthread> others;
  for (uint32_t w = 1; w < std::min<size_t>(threads_, count); ++w)
    others.emplace_back([&, w] {
      run_on_all_cpus();
      loop(w);
    });
  loop(0);
  others.clear();
  if (error) std::rethrow_exception(error);
}

#else

namespace {

// Lets TBB use all processors. It counts those of the thread that uses it first, and starts too few threads if that
// thread is pinned.
struct AllowAllCpus {
  AllowAllCpus() {
    static const std::unique_ptr<tbb::global_control> control =
        static_cast<uint32_t>(tbb::info::default_concurrency()) < cpu_count()
            ? std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, cpu_count())
            : nullptr;
  }
};

// Undoes the pinning of TBB's workers, which inherit it from the thread that happens to start them.
class Unpinned : public tbb::task_scheduler_observer {
 public:
  explicit Unpinned(tbb::task_arena& arena) : tbb::task_scheduler_observer(arena) { observe(true); }
  ~Unpinned() override { observe(false); }
  void on_scheduler_entry(bool is_worker) override {
    if (is_worker) run_on_all_cpus();
  }
};

}  // namespace

struct Executor::Arena : AllowAllCpus, tbb::task_arena {
  explicit Arena(uint32_t threads) : tbb::task_arena(static_cast<int>(threads)), unpinned(*this) {}
  Unpinned unpinned;

  // TBB leaks 7 kB of every destroyed arena that has worked (2021.8), so arenas are pooled. The pool holds at most as
  // many as executors were alive at once.
  struct Idle {
    std::mutex mutex;
    std::multimap<uint32_t, std::unique_ptr<Arena>> by_threads;
  };
  // It is never destroyed: at exit, arenas would outlive the parts of TBB that they need.
  static Idle& idle() {
    static Idle& kept = *new Idle;
    return kept;
  }
  static std::unique_ptr<Arena> take(uint32_t threads) {
    Idle& kept = idle();
    const std::lock_guard lock(kept.mutex);
    auto node = kept.by_threads.extract(threads);
    return node ? std::move(node.mapped()) : std::make_unique<Arena>(threads);
  }
  static void give_back(std::unique_ptr<Arena> arena, uint32_t threads) {
    Idle& kept = idle();
    const std::lock_guard lock(kept.mutex);
    try {
      kept.by_threads.emplace(threads, std::move(arena));
    } catch (const std::bad_alloc&) {
      // Destructors call this, so it must not throw: if the arena cannot be pooled, it is freed.
    }
  }
};

void Executor::inside(const std::function<void()>& work) {
  arena_->execute(work);
}

void Executor::run_on_all(size_t count, const Work& work) {
  arena_->execute([&] {
    tbb::parallel_for(
        size_t{0}, count,
        [&](size_t i) {
          const auto worker = static_cast<uint32_t>(tbb::this_task_arena::current_thread_index());
          const Works works(this, worker);
          work(i, worker);
        },
        tbb::simple_partitioner());
  });
}

#endif

Executor::Executor(uint32_t threads) : threads_(thread_count(threads)), arena_(Arena::take(threads_)) {}
Executor::~Executor() {
  Arena::give_back(std::move(arena_), threads_);
}

}  // namespace sideray::rt
