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
  const rt::TileReach* reach;  // of the tiles' rays; null: they may go anywhere
};

// Returns the tiles (rt::frame_tile_size) that may show any of the movers, on themselves or by rays; all others show the same,
// bit for bit. What lies on the picture's very edge of a tile counts for both.
std::vector<uint8_t> tiles_that_see(std::span<const rt::Mover> movers, const ChangedView& changed);

}  // namespace sideray::bridge
