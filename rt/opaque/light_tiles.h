// Runs the tiles of a request for light on all threads. Under a budget the most important tiles run first, and only as
// many as there is time for.
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

// Returns the order in which tiles are traced; empty: by number. `turns` is as in order_by_turns(), empty without
// history.
inline std::vector<uint32_t> light_tile_order(const LightRequest& r, std::span<const uint32_t> turns) {
  std::vector<uint32_t> order;
  if (!is_bounded(r.work) || is_over(r.work)) return order;
  order = order_of_importance(tile_count(r.width), tile_count(r.height));
  if (!turns.empty()) order_by_turns(turns, order);
  return order;
}

// The tiles of a request that are worked on, and the time for it.
struct LightTiles {
  const LightRequest& request;
  const WorkTime& work;
  std::vector<uint32_t> order;           // empty: of the whole picture, by number
  std::span<const uint8_t> traced = {};  // by tile, whether it is traced; empty: all are
};

// Calls prepare(tile, thread) for each tile unless the request is cancelled. For those that are traced it then calls
// trace(tile, thread) if there is time, and end(tile, thread, whether it was traced).
template <typename Prepare, typename Trace, typename End>
void for_light_tiles(const LightTiles& tiles, Executor& executor, const Prepare& prepare, const Trace& trace,
                     const End& end) {
  const LightRequest& r = tiles.request;
  const std::vector<uint32_t>& order = tiles.order;
  const size_t count = order.empty() ? size_t{tile_count(r.width)} * tile_count(r.height) : order.size();
  TileReach* reach = r.wanted ? r.wanted->reach.get() : nullptr;
  if (reach) reach->fit(r.view, r.width, r.height, r.depth);
  if (is_over(tiles.work) && order.empty())
    return executor.run_cheap(count, [&](size_t tile, uint32_t thread) {
      if (r.cancelled && r.cancelled->load()) return;
      prepare(static_cast<uint32_t>(tile), thread);
      if (tiles.traced.empty() || tiles.traced[tile]) end(static_cast<uint32_t>(tile), thread, false);
    });
  WorkClock clock(tiles.work);
  std::atomic<size_t> next{0};
  executor.run(count, [&](size_t numbered, uint32_t thread) {
    if (r.cancelled && r.cancelled->load()) return;
    const size_t number = order.empty() ? numbered : next++;
    const auto tile = order.empty() ? static_cast<uint32_t>(numbered) : order[number];
    prepare(tile, thread);
    if (!tiles.traced.empty() && !tiles.traced[tile]) return;
    const bool is_traced = clock.run(number, [&] {
      Following rays(r.wanted && r.wanted->has(tile) ? reach : nullptr, Following::Rays::of_reflections);
      trace(tile, thread);
      rays.add_to(tile);
    });
    end(tile, thread, is_traced);
  });
}

}  // namespace sideray::rt
