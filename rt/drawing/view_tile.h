// Lists the pixels of a tile in blocks of 4x4, whose rays are neighbours in a packet, and their rays. It has scratch
// memory: one object per thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/view_rays.h"

namespace sideray::rt {

struct ViewTile {
  static constexpr uint32_t size = 32;  // side in pixels
  static uint32_t tiles_in(uint32_t pixels) { return (pixels + size - 1) / size; }
  static size_t tiles_in(uint32_t width, uint32_t height) { return size_t{tiles_in(width)} * tiles_in(height); }

  std::vector<glm::uvec2> pixels;
  std::vector<Ray> rays;  // one a pixel, up to the far plane
  std::vector<Cone> cones;

  // Refills all three with the pixels of a tile inside the picture; tiles are numbered row by row.
  void aim(const ViewRays& view, uint32_t width, uint32_t height, size_t tile) {
    list(width, height, tile);
    aim(view);
  }

  // Lists the pixels of a tile, without rays and cones.
  void list(uint32_t width, uint32_t height, size_t tile) {
    constexpr uint32_t side = 4, blocks = size / side;
    const uint32_t x0 = static_cast<uint32_t>(tile % tiles_in(width)) * size;
    const uint32_t y0 = static_cast<uint32_t>(tile / tiles_in(width)) * size;
    pixels.clear();
    for (uint32_t i = 0; i < size * size; ++i) {
      const uint32_t block = i / (side * side), in_block = i % (side * side);
      const glm::uvec2 p(x0 + block % blocks * side + in_block % side, y0 + block / blocks * side + in_block / side);
      if (p.x < width && p.y < height) pixels.push_back(p);
    }
  }

  // Computes the rays and cones of the listed pixels.
  void aim(const ViewRays& view) {
    const size_t blocks = (pixels.size() + ViewRays::Block::size - 1) / ViewRays::Block::size;
    rays.resize(blocks * ViewRays::Block::size);
    cones.resize(rays.size());
    ViewRays::Block block;
    for (size_t first = 0; first < rays.size(); first += ViewRays::Block::size) {
      for (size_t i = 0; i < ViewRays::Block::size; ++i) {
        const glm::uvec2 p = pixels[std::min(first + i, pixels.size() - 1)];
        block.x[i] = p.x;
        block.y[i] = p.y;
        block.depth[i] = view.far_depth();
      }
      view.fill(block, DepthFormat::d32f, &rays[first], &cones[first]);
    }
    rays.resize(pixels.size());
    cones.resize(pixels.size());
  }
};

}  // namespace sideray::rt
