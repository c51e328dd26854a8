#include "bridge/transport/tile_rectangles.h"

#include <algorithm>

#include "rt/base/pixels.h"

namespace sideray::bridge {
namespace {

// Cost of a rectangle in texels: an NVIDIA H200 took 16 us for each, and as long for 0.4 MB of texels.
constexpr uint64_t texels_of_rectangle = 1 << 16;

uint64_t area_of(const Rectangle& r) {
  return uint64_t{r.width} * r.height;
}

Rectangle around(const Rectangle& a, const Rectangle& b) {
  const uint32_t x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

class Tiles {
 public:
  Tiles(std::span<const uint8_t> wanted, uint32_t tile, uint32_t width, uint32_t height)
      : wanted_(wanted), tile_(tile), width_(width), height_(height) {}

  uint32_t columns() const { return (width_ + tile_ - 1) / tile_; }
  uint32_t rows() const { return (height_ + tile_ - 1) / tile_; }
  bool wants(uint32_t column, uint32_t row) const { return wanted_[size_t{row} * columns() + column] != 0; }
  // Returns the first column from `column` on whose wanted state is `wanted`; columns() where there is none.
  uint32_t next(uint32_t column, uint32_t row, bool wanted) const {
    while (column < columns() && wants(column, row) != wanted) ++column;
    return column;
  }
  Rectangle run(uint32_t first, uint32_t end, uint32_t row) const {
    const uint32_t x = first * tile_, y = row * tile_;
    return {x, y, std::min(end * tile_, width_) - x, std::min(tile_, height_ - y)};
  }

 private:
  std::span<const uint8_t> wanted_;
  uint32_t tile_, width_, height_;
};

// Merges neighbouring tiles of a row, and equal runs of neighbouring rows.
std::vector<Rectangle> by_texels(const Tiles& tiles) {
  constexpr size_t none = ~size_t{0};
  std::vector<Rectangle> rectangles;
  std::vector<size_t> starting(tiles.columns(), none);  // the last rectangle that starts at a column
  for (uint32_t row = 0; row < tiles.rows(); ++row)
    for (uint32_t first = tiles.next(0, row, true); first < tiles.columns();) {
      const uint32_t end = tiles.next(first, row, false);
      const Rectangle run = tiles.run(first, end, row);
      Rectangle* below = starting[first] == none ? nullptr : &rectangles[starting[first]];
      if (below && below->width == run.width && below->y + below->height == run.y) {
        below->height += run.height;
      } else {
        starting[first] = rectangles.size();
        rectangles.push_back(run);
      }
      first = tiles.next(end, row, true);
    }
  return rectangles;
}

std::vector<Rectangle> by_rectangles(const Tiles& tiles) {
  std::vector<Rectangle> bands;
  for (uint32_t row = 0; row < tiles.rows(); ++row) {
    const uint32_t first = tiles.next(0, row, true);
    if (first == tiles.columns()) continue;
    uint32_t end = tiles.columns();
    while (!tiles.wants(end - 1, row)) --end;
    const Rectangle run = tiles.run(first, end, row);
    if (!bands.empty()) {
      const Rectangle both = around(bands.back(), run);
      if (area_of(both) <= area_of(bands.back()) + area_of(run) + texels_of_rectangle) {
        bands.back() = both;
        continue;
      }
    }
    bands.push_back(run);
  }
  return bands;
}

}  // namespace

std::vector<Rectangle> rectangles_of(std::span<const uint8_t> wanted, uint32_t tile, uint32_t width, uint32_t height,
                                     RectangleCost cost) {
  const Tiles tiles(wanted, tile, width, height);
  return cost == RectangleCost::texels ? by_texels(tiles) : by_rectangles(tiles);
}

std::vector<Rectangle> rectangles_around(const gl::Functions& gl, std::span<const uint8_t> wanted, uint32_t width,
                                         uint32_t height) {
  const RectangleCost cost = gl.software ? RectangleCost::texels : RectangleCost::rectangles;
  return rectangles_of(wanted, rt::frame_tile_size, width, height, cost);
}

}  // namespace sideray::bridge
