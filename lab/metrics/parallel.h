// Runs independent rows on all cores. Results do not depend on the number of threads. Any thread may call it.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace sideray::lab {

// Calls f(y) once for every y in 0..rows-1. f must not throw, and must write only its own row.
template <typename F>
void for_rows(uint32_t rows, const F& f) {
  constexpr uint32_t rows_at_once = 16;
  std::atomic<uint32_t> next{0};
  const auto work = [&] {
    for (uint32_t first; (first = next.fetch_add(rows_at_once)) < rows;)
      for (uint32_t y = first; y < std::min(rows, first + rows_at_once); ++y) f(y);
  };
  const uint32_t blocks = (rows + rows_at_once - 1) / rows_at_once;
  const uint32_t threads = std::min(blocks, std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::jthread> workers;
  for (uint32_t i = 1; i < threads; ++i) workers.emplace_back(work);
  work();
}

}  // namespace sideray::lab
