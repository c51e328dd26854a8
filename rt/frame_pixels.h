// Which pixels of a frame are traced, in the order in which they are: 4x4 blocks inside 32x32 tiles, so that the rays
// of a packet are neighbours. Any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/executor.h"
#include "rt/tracer.h"

namespace sideray::rt {

inline constexpr uint32_t unlimited_layers = 0xffffffffu;

struct PixelRequest {
  uint16_t x, y;
  uint32_t layers;  // at least 1, or unlimited_layers
};

struct FramePixels {
  std::vector<PixelRequest> pixels;
  std::vector<uint8_t> tiles;  // 1 = holds pixels; row-major
};

inline uint32_t tile_count(uint32_t pixels) {
  return (pixels + LayerCache::tile_size - 1) / LayerCache::tile_size;
}

// Refills `frame`. Throws Failure where the request makes no sense.
void gather_pixels(const FrameRequest& request, Executor& executor, FramePixels& frame);

}  // namespace sideray::rt
