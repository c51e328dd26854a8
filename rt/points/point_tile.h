// Holds a tile's opaque pixels by component, for kernels that process sixteen of them at a time. Plain values. Any
// thread may use it.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr int point_tile_size = 32;
inline constexpr int point_tile_pixels = point_tile_size * point_tile_size;
inline constexpr int point_block = 4;    // side of a block in pixels
inline constexpr int block_pixels = 16;  // row by row
inline constexpr int blocks_across = point_tile_size / point_block;
inline constexpr int tile_blocks = blocks_across * blocks_across;  // row by row

// Holds the fields of DepthPoint for all pixels of a tile, block by block. Values are defined only for pixels in
// `drawn`.
struct PointTile {
  alignas(64) float front[3][point_tile_pixels];
  float back[3][point_tile_pixels], normal[3][point_tile_pixels];
  float doubt[point_tile_pixels], skip[point_tile_pixels];
  float bias[point_tile_pixels];  // set only for pixels in `inexact`
  // Bit i of a block stands for its pixel i.
  uint16_t drawn[tile_blocks];    // bit set: it shows a surface
  uint16_t inexact[tile_blocks];  // bit set: it takes the inexact test
  uint32_t x0, y0;                // the tile's first pixel in the picture
};

// Return the column and row of a pixel in its tile, from its index.
constexpr uint32_t column_in_tile(uint32_t index) {
  return index / block_pixels % blocks_across * point_block + index % point_block;
}
constexpr uint32_t row_in_tile(uint32_t index) {
  return index / block_pixels / blocks_across * point_block + index % block_pixels / point_block;
}

}  // namespace sideray::rt
