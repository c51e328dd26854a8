// Finds the tiles of a picture that may see a moved object. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gl/scene/raster_view.h"
#include "model/snapshot.h"
#include "rt/reach/tile_reach.h"
#include "rt/scene/scene_difference.h"

namespace sideray::bridge {

// Holds a view of two snapshots that differ only by movers.
struct ChangedView {
  const model::Snapshot& before;
  const model::Snapshot& now;
  const gl::RasterView& view;
  uint32_t width, height;
  const rt::TileReach* reach;  // where the rays of each tile go; null: unknown
  bool bounces;                // rays include paths of bounced light
};

// Says what a tile shows of movers: nothing, to the bit; only sprites drawn over an unchanged picture; or anything.
enum TileChange : uint8_t { tile_unchanged, tile_drawn_over, tile_changed };

// Returns the change of each tile (rt::frame_tile_size), row by row.
std::vector<uint8_t> tiles_that_see(std::span<const rt::Mover> movers, const ChangedView& changed);

}  // namespace sideray::bridge
