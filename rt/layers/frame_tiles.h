// Clears tiles of a frame's results and marks them as changed. One thread calls it; the executor's threads clear.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "rt/base/executor.h"
#include "rt/base/pixels.h"

namespace sideray::rt {

// Calls clear(first texel, texel count) for each row of every tile that is set in `tiles`, in a plane of one layer.
template <typename Clear>
void for_tile_rows(uint32_t width, uint32_t height, const std::vector<uint8_t>& tiles, Executor& executor,
                   const Clear& clear) {
  constexpr uint32_t size = frame_tile_size;
  const uint32_t columns = tile_count(width);
  executor.run(tile_count(height), [&](size_t row, uint32_t) {
    const uint32_t y0 = static_cast<uint32_t>(row) * size, y1 = std::min(y0 + size, height);
    for (uint32_t column = 0; column < columns; ++column) {
      if (!tiles[row * columns + column]) continue;
      const uint32_t x0 = column * size, count = std::min(size, width - x0);
      for (uint32_t y = y0; y < y1; ++y) clear(size_t{y} * width + x0, count);
    }
  });
}

// Marks the tiles that change: all tiles of a new target, otherwise those with answers now or before. If `changing` is
// not empty, tiles that it leaves out stay as they are.
inline void mark_tiles(bool fresh, const std::vector<uint8_t>& tiles, const std::vector<uint8_t>& changing,
                       std::vector<uint8_t>& traced, std::vector<uint8_t>& dirty) {
  dirty.assign(tiles.size(), 1);
  traced.resize(tiles.size());
  for (size_t i = 0; i < tiles.size(); ++i) {
    const bool stays = !changing.empty() && !changing[i];
    if (!fresh) dirty[i] = stays ? 0 : tiles[i] | traced[i];
    if (fresh || !stays) traced[i] = tiles[i];
  }
}

}  // namespace sideray::rt
