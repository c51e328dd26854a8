// Says which tiles of a picture are redrawn. Other tiles are not traced, filtered or uploaded, except where filters
// read around the wanted ones. Any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "rt/base/pixels.h"
#include "rt/reach/tile_reach.h"

namespace sideray::rt {

struct WantedTiles {
  std::vector<uint8_t> tiles;        // of frame_tile_size pixels, row by row; empty: all are wanted
  std::shared_ptr<TileReach> reach;  // records the rays of those tiles; or null

  bool none() const { return !tiles.empty() && std::ranges::find(tiles, 1) == tiles.end(); }
  bool has(size_t tile) const { return tiles.empty() || tiles[tile] != 0; }
};

// Returns the tiles and those up to `by` tiles around them, in a picture with `columns` columns of tiles.
std::vector<uint8_t> grown(const std::vector<uint8_t>& tiles, uint32_t columns, uint32_t by);

// Returns the tiles to trace: the wanted ones and those that filters read; empty: all.
std::vector<uint8_t> traced_tiles(const WantedTiles* wanted, uint32_t width, uint32_t read_around);

}  // namespace sideray::rt
