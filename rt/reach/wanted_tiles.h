// Says which tiles of a picture are drawn anew. The others are not traced, filtered or uploaded, except what filters
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
  std::shared_ptr<TileReach> reach;  // records where the rays of those tiles go; or null

  bool none() const { return !tiles.empty() && std::ranges::find(tiles, 1) == tiles.end(); }
  bool has(size_t tile) const { return tiles.empty() || tiles[tile] != 0; }
};

// Returns the tiles and those up to `by` tiles beside them, in a picture with so many columns of tiles.
std::vector<uint8_t> grown(const std::vector<uint8_t>& tiles, uint32_t columns, uint32_t by);

// Returns the tiles in which rays are needed for what is wanted, with those that filters read; empty: all.
std::vector<uint8_t> traced_tiles(const WantedTiles* wanted, uint32_t width, uint32_t read_around);

}  // namespace sideray::rt
