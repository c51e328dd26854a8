#include "rt/layers/frame_pixels.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <numeric>

#include "model/failure.h"
#include "rt/base/view_rays.h"

namespace sideray::rt {
namespace {

constexpr uint32_t largest_size = 65535;

uint16_t to_u16(uint32_t coordinate) {
  return static_cast<uint16_t>(coordinate);
}

bool is_of_bytes(sideray_mask_source mask) {
  return mask == SIDERAY_MASK_TEXTURE || mask == SIDERAY_MASK_MEMORY;
}

void check(const LayerRequest& r, const PixelSelection& selection) {
  if (r.width == 0 || r.height == 0 || r.width > largest_size || r.height > largest_size)
    fail(SIDERAY_INVALID_ARGUMENT, "frame of {}x{}: each side must be 1 to {}", r.width, r.height, largest_size);
  const bool bytes = is_of_bytes(r.mask);
  if (bytes && r.mask_bytes.size() != size_t{r.width} * r.height)
    fail(SIDERAY_INTERNAL, "frame mask: {} bytes for {}x{} pixels", r.mask_bytes.size(), r.width, r.height);
  if ((bytes || r.mask == SIDERAY_MASK_NONE) && selection.requested_bits == 0) return;
  if (!r.depth.texels || !has_stencil(r.depth.format))
    fail(SIDERAY_INVALID_ARGUMENT, "frame mask: the depth buffer has no stencil; attach one, or use no mask");
  if (bytes || r.mask == SIDERAY_MASK_NONE) return;
  if (r.stencil_bits == 0 || r.stencil_bits > 0xff || (r.stencil_bits & (r.stencil_bits + 1)))
    fail(SIDERAY_INVALID_ARGUMENT, "stencil_bits {:#x}: give contiguous bits from bit 0, at most 0xff", r.stencil_bits);
}

// Reads only the stencil; returns 0 if there is none.
class StencilReader {
 public:
  explicit StencilReader(const DepthImage& image) : image_(image) {
    const bool wide = image.format == DepthFormat::d32f_s8;
    pixel_bytes_ = wide ? 8 : 4;
    offset_ = wide ? 4 : 0;
    has_ = image.texels && has_stencil(image.format);
  }
  uint32_t at(uint32_t x, uint32_t y) const {
    if (!has_) return 0;
    uint32_t word;
    std::memcpy(&word, image_.texels + y * image_.row_bytes + x * pixel_bytes_ + offset_, sizeof(word));
    return word & 0xffu;
  }
  // Returns the union of the bits of the pixels x0 <= x < x1.
  uint32_t any(uint32_t x0, uint32_t x1, uint32_t y) const {
    uint32_t bits = 0;
    for (uint32_t x = x0; x < x1; ++x) bits |= at(x, y);
    return bits;
  }

 private:
  DepthImage image_;
  size_t pixel_bytes_, offset_;
  bool has_;
};

// Gathers the pixels of tiles; each thread has its own object.
class Gatherer {
 public:
  Gatherer(const LayerRequest& request, const PixelSelection& selection, std::vector<PixelRequest>& pixels)
      : request_(request),
        selection_(selection),
        pattern_(selection.pattern),
        stencil_(request.depth),
        reads_stencil_(!(is_of_bytes(request.mask) || request.mask == SIDERAY_MASK_NONE) ||
                       selection.requested_bits != 0),
        pixels_(pixels) {}

  void gather_tile(uint32_t x0, uint32_t y0) {
    const uint32_t x1 = std::min(x0 + LayerCache::tile_size, request_.width);
    const uint32_t y1 = std::min(y0 + LayerCache::tile_size, request_.height);
    const uint32_t block_width = traced_block * pattern_.cell_width, block_height = traced_block * pattern_.cell_height;
    for (uint32_t by = y0; by < y1; by += block_height)
      for (uint32_t bx = x0; bx < x1; bx += block_width) {
        const uint32_t ex = std::min(bx + block_width, x1), ey = std::min(by + block_height, y1);
        if (!wants_any(bx, by, ex, ey)) continue;
        for (uint32_t y = by; y < ey; ++y)
          for (uint32_t x = bx; x < ex; ++x) gather(x, y);
      }
  }

  uint64_t masked = 0, requested = 0;

 private:
  // Returns whether the mask requests layers anywhere in a block. In most of a picture it does not.
  bool wants_any(uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) const {
    uint32_t stencil = 0, bytes = 0;
    for (uint32_t y = y0; y < y1; ++y) {
      if (reads_stencil_) stencil |= stencil_.any(x0, x1, y);
      if (!is_of_bytes(request_.mask)) continue;
      const uint8_t* row = request_.mask_bytes.data() + size_t{y} * request_.width;
      bytes |= std::reduce(row + x0, row + x1, uint32_t{0}, std::bit_or<>());
    }
    if (selection_.requested_bits != 0 && (stencil & selection_.requested_bits) == 0) return false;
    return request_.mask == SIDERAY_MASK_NONE || bytes != 0 || (stencil & request_.stencil_bits) != 0;
  }

  // Returns the number of layers that the mask requests at a pixel; 0 = none.
  uint32_t wanted(uint32_t x, uint32_t y) const {
    const uint32_t most = request_.max_layers ? request_.max_layers : unlimited_layers;
    const bool bytes = is_of_bytes(request_.mask);
    const uint32_t stencil = reads_stencil_ ? stencil_.at(x, y) : 0;
    if (selection_.requested_bits != 0 && (stencil & selection_.requested_bits) == 0) return 0;
    if (request_.mask == SIDERAY_MASK_NONE) return most;
    const uint32_t saturated = bytes ? 0xff : request_.stencil_bits;
    const uint32_t value = bytes ? request_.mask_bytes[size_t{y} * request_.width + x] : stencil & saturated;
    if (value == 0) return 0;
    const bool counted = request_.mask != SIDERAY_MASK_STENCIL && selection_.counted && value != saturated;
    return counted ? std::min(value, most) : most;
  }

  void gather(uint32_t x, uint32_t y) {
    const uint32_t own = wanted(x, y);
    masked += own > 0;
    requested += own == unlimited_layers ? 0 : own;
    if (is_single_) {
      if (own > 0) pixels_.push_back({to_u16(x), to_u16(y), own, to_u16(x), to_u16(y)});
      return;
    }
    if (!pattern_.traces(x, y)) return;
    PixelRequest pixel{to_u16(x), to_u16(y), own, to_u16(x), to_u16(y)};
    if (request_.depth.texels)
      for (uint32_t v = y; v < std::min(y + pattern_.cell_height, request_.height); ++v)
        for (uint32_t u = x; u < std::min(x + pattern_.cell_width, request_.width); ++u)
          if (u != x || v != y) answer_for(u, v, pixel);
    if (pixel.layers > 0) pixels_.push_back(pixel);
  }

  // Makes the traced pixel of a cell collect layers for (x, y) too, if (x, y) sees farther. Then the ray passes the
  // opaque surface of its own pixel and ends at the depth of (x, y), with the larger of both layer counts. Surfaces
  // behind the opaque one serve only neighbours.
  void answer_for(uint32_t x, uint32_t y, PixelRequest& pixel) const {
    const uint32_t layers = wanted(x, y);
    if (layers == 0 || !sees_farther(x, y, pixel.x, pixel.y)) return;
    pixel.layers = std::max(pixel.layers, layers);
    if (sees_farther(x, y, pixel.end_x, pixel.end_y)) {
      pixel.end_x = to_u16(x);
      pixel.end_y = to_u16(y);
    }
  }

  bool sees_farther(uint32_t x, uint32_t y, uint32_t than_x, uint32_t than_y) const {
    const double here = read_depth(request_.depth, x, y).depth;
    const double there = read_depth(request_.depth, than_x, than_y).depth;
    return request_.view.reversed_depth ? here < there : here > there;
  }

  const LayerRequest& request_;
  const PixelSelection& selection_;
  RatePattern pattern_;
  bool is_single_ = pattern_.cell_width == 1 && pattern_.cell_height == 1;  // each pixel has its own ray
  StencilReader stencil_;
  bool reads_stencil_;
  std::vector<PixelRequest>& pixels_;
};

// Joins the parts' pixels in order.
void join_parts(Executor& executor, FramePixels& frame) {
  frame.masked = frame.requested = 0;
  size_t pixels = 0;
  for (FramePixels::Part& part : frame.parts) {
    part.first = pixels;
    pixels += part.pixels.size();
    frame.masked += part.masked;
    frame.requested += part.requested;
  }
  frame.pixels.resize(pixels);
  executor.run(frame.parts.size(), [&](size_t i, uint32_t) {
    const FramePixels::Part& part = frame.parts[i];
    std::ranges::copy(part.pixels, frame.pixels.begin() + static_cast<ptrdiff_t>(part.first));
  });
}

}  // namespace

RatePattern pattern_of(sideray_cache_rate rate) {
  switch (rate) {
    case SIDERAY_RATE_CHECKERBOARD:
      return {2, 1, true};
    case SIDERAY_RATE_INTERLEAVED:
      return {1, 2, false};
    case SIDERAY_RATE_QUARTER:
      return {2, 2, false};
    default:
      return {};
  }
}

// A second wave may request any pixels, so it ignores the cache rate.
PixelSelection selection_of(const CacheRequest& request) {
  return {request.requested_bits != 0 ? RatePattern{} : pattern_of(request.cache_rate), request.requested_bits, true};
}

void gather_pixels(const LayerRequest& request, const PixelSelection& selection, Executor& executor,
                   FramePixels& frame) {
  check(request, selection);
  // Splits rows into parts, because most translucent surfaces may lie in few rows.
  constexpr uint32_t parts = 4;
  const uint32_t columns = tile_count(request.width), rows = tile_count(request.height);
  frame.tiles.assign(size_t{columns} * rows, 0);
  frame.parts.resize(size_t{rows} * parts);
  executor.run(frame.parts.size(), [&](size_t index, uint32_t) {
    const auto row = static_cast<uint32_t>(index / parts), part = static_cast<uint32_t>(index % parts);
    FramePixels::Part& found = frame.parts[index];
    found.pixels.clear();
    Gatherer gatherer(request, selection, found.pixels);
    for (uint32_t column = part * columns / parts; column < (part + 1) * columns / parts; ++column) {
      const size_t before = found.pixels.size();
      gatherer.gather_tile(column * LayerCache::tile_size, row * LayerCache::tile_size);
      frame.tiles[size_t{row} * columns + column] = found.pixels.size() > before;
    }
    found.masked = gatherer.masked;
    found.requested = gatherer.requested;
  });
  join_parts(executor, frame);
}

FramePixels every_pixel(uint32_t width, uint32_t height, Executor& executor) {
  LayerRequest request;
  request.width = width;
  request.height = height;
  request.mask = SIDERAY_MASK_NONE;
  request.max_layers = 0;  // unlimited
  FramePixels frame;
  gather_pixels(request, {}, executor, frame);
  return frame;
}

}  // namespace sideray::rt
