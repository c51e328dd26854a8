// Runs the tiles of a request for light on all threads: under a budget those that matter most first, and only those that
// there is time for.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/opaque/light_request.h"
#include "rt/reach/tile_reach.h"
#include "rt/reach/wanted_tiles.h"

namespace sideray::rt {

// Returns the tiles of the picture in the order in which they are to be traced; empty: as they are numbered. `turns`: as in
// order_by_turns(), empty where there is no history.
inline std::vector<uint32_t> light_tile_order(const LightRequest& r, std::span<const uint32_t> turns) {
  std::vector<uint32_t> order;
  if (!is_bounded(r.work)) return order;
  order = order_of_importance(tile_count(r.width), tile_count(r.height));
  if (!turns.empty()) order_by_turns(turns, order);
  return order;
}

// For each tile of `order` (empty: of the picture), unless the request is cancelled, calls prepare(tile, thread); and, where
// the tile is in `traced` (empty: all are), trace(tile, thread) if there is time for it, and end(tile, thread, whether it was
// traced).
template <typename Prepare, typename Trace, typename End>
void for_light_tiles(const LightRequest& r, const WorkTime& work, Executor& executor, const std::vector<uint32_t>& order,
                     const std::vector<uint8_t>& traced, const Prepare& prepare, const Trace& trace, const End& end) {
  const size_t count = order.empty() ? size_t{tile_count(r.width)} * tile_count(r.height) : order.size();
  TileReach* reach = r.wanted ? r.wanted->reach.get() : nullptr;
  if (reach) reach->fit(r.view, r.width, r.height, r.depth);
  WorkClock clock(work);
  std::atomic<size_t> next{0};
  executor.run(count, [&](size_t numbered, uint32_t thread) {
    if (r.cancelled && r.cancelled->load()) return;
    const size_t number = order.empty() ? numbered : next++;
    const auto tile = order.empty() ? static_cast<uint32_t>(numbered) : order[number];
    prepare(tile, thread);
    if (!traced.empty() && !traced[tile]) return;
    const bool is_traced = clock.run(number, [&] {
      Following rays(r.wanted && r.wanted->has(tile) ? reach : nullptr, Following::Rays::of_reflections);
      trace(tile, thread);
      rays.add_to(tile);
    });
    end(tile, thread, is_traced);
  });
}

}  // namespace sideray::rt
