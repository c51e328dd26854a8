#include "rt/frame_pixels.h"

#include <algorithm>

#include "model/failure.h"
#include "rt/view_rays.h"

namespace sideray::rt {
namespace {

constexpr uint32_t block_size = 4;
constexpr uint32_t largest_size = 65535;

void check(const FrameRequest& r) {
  if (r.width == 0 || r.height == 0 || r.width > largest_size || r.height > largest_size)
    fail(SIDERAY_INVALID_ARGUMENT, "frame of {}x{}: each side must be 1 to {}", r.width, r.height, largest_size);
  if (r.mask == SIDERAY_MASK_NONE) return;
  if (!r.depth.texels || !has_stencil(r.depth.format))
    fail(SIDERAY_INVALID_ARGUMENT, "frame mask: the depth buffer has no stencil; attach one, or use no mask");
  if (r.stencil_bits == 0 || r.stencil_bits > 0xff || (r.stencil_bits & (r.stencil_bits + 1)))
    fail(SIDERAY_INVALID_ARGUMENT, "stencil_bits {:#x}: give contiguous bits from bit 0, at most 0xff", r.stencil_bits);
}

// Layers to trace at a pixel; 0 = none.
uint32_t requested_layers(const FrameRequest& request, uint32_t x, uint32_t y) {
  const uint32_t most = request.max_layers ? request.max_layers : unlimited_layers;
  if (request.mask == SIDERAY_MASK_NONE) return most;
  // A bent ray leaves the pixel that its surfaces were counted in; particles are not counted.
  const bool counts = request.mask == SIDERAY_MASK_COUNT && !request.refraction && !request.particles;
  const uint32_t value = read_depth(request.depth, x, y).stencil & request.stencil_bits;
  if (value == 0) return 0;
  const bool counted = counts && value != request.stencil_bits;
  return counted ? std::min(value, most) : most;
}

void gather_tile(const FrameRequest& request, uint32_t x0, uint32_t y0, std::vector<PixelRequest>& pixels) {
  const uint32_t x1 = std::min(x0 + LayerCache::tile_size, request.width);
  const uint32_t y1 = std::min(y0 + LayerCache::tile_size, request.height);
  for (uint32_t by = y0; by < y1; by += block_size)
    for (uint32_t bx = x0; bx < x1; bx += block_size)
      for (uint32_t y = by; y < std::min(by + block_size, y1); ++y)
        for (uint32_t x = bx; x < std::min(bx + block_size, x1); ++x)
          if (const uint32_t layers = requested_layers(request, x, y))
            pixels.push_back({static_cast<uint16_t>(x), static_cast<uint16_t>(y), layers});
}

}  // namespace

void gather_pixels(const FrameRequest& request, Executor& executor, FramePixels& frame) {
  check(request);
  const uint32_t columns = tile_count(request.width), rows = tile_count(request.height);
  frame.tiles.assign(size_t{columns} * rows, 0);
  frame.pixels.clear();
  std::vector<std::vector<PixelRequest>> found(rows);
  executor.run(rows, [&](size_t row, uint32_t) {
    for (uint32_t column = 0; column < columns; ++column) {
      const size_t before = found[row].size();
      gather_tile(request, column * LayerCache::tile_size, static_cast<uint32_t>(row) * LayerCache::tile_size,
                  found[row]);
      frame.tiles[row * columns + column] = found[row].size() > before;
    }
  });
  for (const std::vector<PixelRequest>& row : found) frame.pixels.insert(frame.pixels.end(), row.begin(), row.end());
}

}  // namespace sideray::rt
