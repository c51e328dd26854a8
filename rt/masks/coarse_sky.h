// Holds the sky's visibility at every eighth pixel each way, which other pixels use until their own rays are traced.
// Without it, after a cut under a budget, most of a picture would be lit by an unoccluded sky. Different tiles may be
// written and read at the same time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/pixels.h"

namespace sideray::rt {

struct SkyShare {
  uint8_t open = 255, unhidden = 255;  // as OcclusionMasks::open; the share that nothing opaque occludes
};

class CoarseSky {
 public:
  static constexpr uint32_t step = 8;  // side in pixels of the square that one sample represents
  static constexpr uint32_t across = frame_tile_size / step;

  // Resets all tiles.
  void begin(uint32_t width, uint32_t height);
  // Starts a tile, whose samples follow.
  void start(size_t tile) { tiles_[tile] = {.known = true, .samples = {}}; }
  // Stores the sample of the pixel in this column and row of the tile.
  void add(size_t tile, uint32_t column, uint32_t row, SkyShare share) {
    tiles_[tile].samples[row / step * across + column / step] = {share, true};
  }
  bool knows(size_t tile) const { return tiles_[tile].known; }
  // Returns the mean of the samples around a pixel of the tile, mostly of those at its depth. `depths` has all pixels
  // of the picture, along the view axis. Without samples the sky is unoccluded.
  SkyShare at(size_t tile, uint32_t x, uint32_t y, std::span<const float> depths) const;

 private:
  struct Sample {
    SkyShare share;
    bool exists = false;
  };
  struct Tile {
    bool known = false;
    std::array<Sample, across * across> samples;
  };
  uint32_t width_ = 0, height_ = 0;
  std::vector<Tile> tiles_;
};

}  // namespace sideray::rt
