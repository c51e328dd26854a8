// Tiles of a picture as rectangles, for uploads. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bridge/transport/texture_upload.h"

namespace sideray::bridge {

// Says what an upload costs where.
enum class RectangleCost {
  texels,      // in software: each texel is copied, and a call costs little
  rectangles,  // on a device: each rectangle costs as much as tens of thousands of texels
};

// Returns disjoint rectangles that cover the wanted tiles, row 0 first: of tiles with `tile` pixels a side, cut off at
// width and height, a byte each that is 0 where a tile is not wanted. By texels they cover nothing else. By rectangles
// they are bands of rows, as wide as what is wanted in them, and two are one where what lies between costs less.
std::vector<Rectangle> rectangles_of(std::span<const uint8_t> wanted, uint32_t tile, uint32_t width, uint32_t height,
                                     RectangleCost cost);
// Returns those around tiles of a frame, at this device's cost. What else they cover is not to matter.
std::vector<Rectangle> rectangles_around(const gl::Functions& gl, std::span<const uint8_t> wanted, uint32_t width,
                                         uint32_t height);

}  // namespace sideray::bridge
