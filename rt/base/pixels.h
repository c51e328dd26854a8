// Lists the traced pixels of a frame, and the tiles in which they are traced. Plain values; any thread may use them.
#pragma once

#include <cstdint>
#include <vector>

namespace sideray::rt {

inline constexpr uint32_t unlimited_layers = 0xffffffffu;

struct PixelRequest {
  uint16_t x, y;
  uint32_t layers;        // at least 1, or unlimited_layers
  uint16_t end_x, end_y;  // the pixel whose depth ends the ray: itself, or one that this one represents
};

struct FramePixels {
  std::vector<PixelRequest> pixels;
  std::vector<uint8_t> tiles;  // 1 = holds pixels; row-major
  // Pixels and layers that the mask requests, traced or not; pixels with unlimited layers add no layers.
  uint64_t masked, requested;

  // Scratch memory of a part of a row of tiles, reused by the next frame.
  struct Part {
    std::vector<PixelRequest> pixels;
    size_t first = 0;  // index of the row's first pixel in the frame's list
    uint64_t masked = 0, requested = 0;
  };
  std::vector<Part> parts;
};

// The side of a square tile, in pixels.
inline constexpr uint32_t frame_tile_size = 32;

inline uint32_t tile_count(uint32_t pixels) {
  return (pixels + frame_tile_size - 1) / frame_tile_size;
}

}  // namespace sideray::rt
