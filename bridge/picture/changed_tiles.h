// Finds the tiles of a picture that may see what has moved. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gl/scene/raster_view.h"
#include "model/snapshot.h"
#include "rt/reach/tile_reach.h"
#include "rt/scene/scene_difference.h"

namespace sideray::bridge {

// A view of two snapshots, which differ by movers alone.
struct ChangedView {
  const model::Snapshot& before;
  const model::Snapshot& now;
  const gl::RasterView& view;
  uint32_t width, height;
  const rt::TileReach* reach;  // where the rays of each tile go; null: unknown
  bool bounces;                // paths of light that bounces are among them
};

// What a tile shows of movers: nothing, to the bit; sprites that are drawn over what is the same as before; or anything.
enum TileChange : uint8_t { tile_unchanged, tile_drawn_over, tile_changed };

// Returns it for each tile (rt::frame_tile_size), row by row.
std::vector<uint8_t> tiles_that_see(std::span<const rt::Mover> movers, const ChangedView& changed);

}  // namespace sideray::bridge
