// Holds a tile's opaque pixels by component, for kernels that work on sixteen of them at a time. Plain values. Any
// thread may use it.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr int point_tile_size = 32;
inline constexpr int point_tile_pixels = point_tile_size * point_tile_size;
inline constexpr int point_block = 4;    // pixels along each side of a block
inline constexpr int block_pixels = 16;  // in a block, row by row
inline constexpr int blocks_across = point_tile_size / point_block;
inline constexpr int tile_blocks = blocks_across * blocks_across;  // row by row

// Holds what DepthPoint has, of all pixels of a tile, block by block. Values count only where a pixel is drawn.
struct PointTile {
  alignas(64) float front[3][point_tile_pixels];
  float back[3][point_tile_pixels], normal[3][point_tile_pixels];
  float doubt[point_tile_pixels], skip[point_tile_pixels];
  float bias[point_tile_pixels];  // set only where the pixel takes an inexact test
  // Bit i of a block stands for its pixel i.
  uint16_t drawn[tile_blocks];    // it shows a surface
  uint16_t inexact[tile_blocks];  // it takes the inexact test
  uint32_t x0, y0;                // the tile's first pixel in the picture
};

// Return the column and row of a pixel in its tile, by its index there.
constexpr uint32_t column_in_tile(uint32_t index) {
  return index / block_pixels % blocks_across * point_block + index % point_block;
}
constexpr uint32_t row_in_tile(uint32_t index) {
  return index / block_pixels / blocks_across * point_block + index % block_pixels / point_block;
}

}  // namespace sideray::rt
