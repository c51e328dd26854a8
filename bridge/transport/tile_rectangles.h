// Converts tiles of a picture to rectangles for uploads. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bridge/transport/texture_upload.h"

namespace sideray::bridge {

// Says what dominates the cost of an upload.
enum class RectangleCost {
  texels,      // in software: each texel is copied, and a call costs little
  rectangles,  // on a device: each rectangle costs as much as tens of thousands of texels
};

// Returns disjoint rectangles that cover the wanted tiles, row 0 first. Tiles have `tile` pixels a side, cut off at
// width and height; `wanted` has a byte for each, 0 = not wanted. By texels they cover nothing else. By rectangles they
// are bands of rows as wide as the wanted tiles, merged where the area between costs less than a rectangle.
std::vector<Rectangle> rectangles_of(std::span<const uint8_t> wanted, uint32_t tile, uint32_t width, uint32_t height,
                                     RectangleCost cost);
// Returns rectangles around tiles of a frame, at this device's cost. They may also cover tiles that are not wanted.
std::vector<Rectangle> rectangles_around(const gl::Functions& gl, std::span<const uint8_t> wanted, uint32_t width,
                                         uint32_t height);

}  // namespace sideray::bridge
