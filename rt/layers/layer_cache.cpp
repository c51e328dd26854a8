#include "rt/layers/layer_cache.h"

#include <algorithm>
#include <array>
#include <limits>

#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

constexpr uint16_t half_one = 0x3c00;
constexpr float least_transmittance = 1e-4f;
constexpr float least_distance = std::numeric_limits<float>::min();  // 0 is an empty layer

// Calls clear(first texel of a row, texels) for the rows of every tile that is set in `tiles`, in a plane of one layer.
template <typename Clear>
void for_tile_rows(uint32_t width, uint32_t height, const std::vector<uint8_t>& tiles, Executor& executor,
                   const Clear& clear) {
  constexpr uint32_t size = LayerCache::tile_size;
  const uint32_t columns = tile_count(width);
  executor.run(tile_count(height), [&](size_t row, uint32_t) {
    const uint32_t y0 = static_cast<uint32_t>(row) * size, y1 = std::min(y0 + size, height);
    for (uint32_t column = 0; column < columns; ++column) {
      if (!tiles[row * columns + column]) continue;
      const uint32_t x0 = column * size, count = std::min(size, width - x0);
      for (uint32_t y = y0; y < y1; ++y) clear(size_t{y} * width + x0, count);
    }
  });
}

// Which tiles change: all of a new target, otherwise those with answers now or before.
void mark_tiles(bool fresh, const std::vector<uint8_t>& tiles, std::vector<uint8_t>& traced,
                std::vector<uint8_t>& dirty) {
  dirty.assign(tiles.size(), 1);
  if (!fresh)
    for (size_t i = 0; i < tiles.size(); ++i) dirty[i] = tiles[i] | traced[i];
  traced = tiles;
}

}  // namespace

void begin_cache(const FrameRequest& request, const std::vector<uint8_t>& tiles, Executor& executor,
                 LayerCache& cache) {
  if (request.asked_bits != 0) {
    cache.dirty_tiles = tiles;
    for (size_t i = 0; i < tiles.size(); ++i) cache.traced_tiles[i] |= tiles[i];
    return;
  }
  const bool fresh = cache.width != request.width || cache.height != request.height ||
                     cache.layers != request.max_layers || cache.traced_tiles.size() != tiles.size();
  const size_t plane = size_t{request.width} * request.height, texels = plane * request.max_layers;
  if (fresh) {
    cache.width = request.width, cache.height = request.height, cache.layers = request.max_layers;
    cache.radiance.resize(4 * texels), cache.distance.resize(texels), cache.surface_id.resize(texels);
  }
  mark_tiles(fresh, tiles, cache.traced_tiles, cache.dirty_tiles);
  for_tile_rows(request.width, request.height, cache.dirty_tiles, executor, [&](size_t first, uint32_t count) {
    for (size_t layer = 0; layer < request.max_layers; ++layer) {
      const size_t texel = layer * plane + first;
      std::fill_n(cache.radiance.begin() + static_cast<ptrdiff_t>(4 * texel), 4 * size_t{count}, uint16_t{0});
      std::fill_n(cache.distance.begin() + static_cast<ptrdiff_t>(texel), count, 0.0f);
      std::fill_n(cache.surface_id.begin() + static_cast<ptrdiff_t>(texel), count, 0u);
    }
  });
}

void begin_composite(const FrameRequest& request, const std::vector<uint8_t>& tiles, Executor& executor,
                     CompositeImage& image) {
  const bool fresh =
      image.width != request.width || image.height != request.height || image.traced_tiles.size() != tiles.size();
  if (fresh) {
    const size_t texels = size_t{request.width} * request.height;
    image.width = request.width, image.height = request.height;
    image.radiance.resize(4 * texels), image.transmittance.resize(4 * texels);
  }
  image.half_difference.assign(request.light_samples > 0 ? size_t{request.width} * request.height : 0, glm::vec3(0.0f));
  mark_tiles(fresh, tiles, image.traced_tiles, image.dirty_tiles);
  for_tile_rows(request.width, request.height, image.dirty_tiles, executor, [&](size_t first, uint32_t count) {
    // Nothing is seen of the surroundings but through the transmittance: alpha 1, as store_refracted() has it.
    for (size_t texel = first; texel < first + count; ++texel)
      std::copy_n(std::array<uint16_t, 4>{0, 0, 0, half_one}.begin(), 4, &image.radiance[4 * texel]);
    std::fill_n(image.transmittance.begin() + static_cast<ptrdiff_t>(4 * first), 4 * size_t{count}, half_one);
  });
}

void CacheSink::add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3) {
  const uint16_t halfs[] = {half_bits(radiance->x), half_bits(radiance->y), half_bits(radiance->z)};
  store(pixel, layer, hit, halfs);
}

void CacheSink::store(uint32_t pixel, uint32_t layer, const Hit& hit, const uint16_t radiance[3]) {
  const PixelRequest& p = pixels_[pixel];
  const size_t texel = (size_t{layer} * cache_.height + p.y) * cache_.width + p.x;
  std::copy_n(radiance, 3, &cache_.radiance[4 * texel]);
  cache_.radiance[4 * texel + 3] = half_one;
  cache_.distance[texel] = std::max(static_cast<float>(hit.distance), least_distance);
  cache_.surface_id[texel] = snapshot_.instances[hit.instance].surface_id;
}

void CacheSink::add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                          const RoughReflection& rough) {
  if (!rough_) return;
  const PixelRequest& p = pixels_[pixel];
  const uint32_t in_picture = p.y * cache_.width + p.x;
  const uint32_t texel = layer * cache_.height * cache_.width + in_picture;
  rough_->add(in_picture, texel, cache_.surface_id[texel], point, radiance, rough);
}

void CompositeSink::begin(std::span<const PixelRequest> pixels) {
  pixels_.assign(pixels.size(), {glm::vec3(0.0f), glm::vec3(0.0f), glm::vec3(1.0f)});
}

bool CompositeSink::meet(uint32_t pixel, const SurfacePoint& point, glm::vec3& weight) {
  const shading::SrBlend blend = blend_of(point);
  weight = pixels_[pixel].transmittance * blend.cover;
  pixels_[pixel].transmittance *= blend.through;
  return blend.cover > 0.0f;
}

void CompositeSink::add(uint32_t pixel, uint32_t, const Hit&, const glm::vec3* radiance, glm::vec3 weight) {
  Pixel& p = pixels_[pixel];
  if (!exact_) {
    p.radiance += *radiance * weight;
    return;
  }
  p.radiance += 0.5f * (radiance[0] + radiance[1]) * weight;
  p.half_difference += 0.5f * (radiance[0] - radiance[1]) * weight;
}

bool CompositeSink::finished(uint32_t pixel) const {
  const glm::vec3 t = pixels_[pixel].transmittance;
  const float most = std::max({t.x, t.y, t.z});
  return exact_ ? most <= 0.0f : most < least_transmittance;
}

void CompositeSink::end(std::span<const PixelRequest> pixels) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    const size_t texel = 4 * (size_t{pixels[i].y} * image_.width + pixels[i].x);
    store_rgba(&image_.radiance[texel], pixels_[i].radiance, 1.0f);
    store_rgba(&image_.transmittance[texel], pixels_[i].transmittance, 1.0f);
    if (exact_) image_.half_difference[texel / 4] = pixels_[i].half_difference;
  }
}

void store_refracted(std::span<const PixelRequest> pixels, const std::vector<RefractedPixel>& seen, bool exact,
                     CompositeImage& image) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    const size_t texel = size_t{pixels[i].y} * image.width + pixels[i].x;
    const RefractedPixel& p = seen[i];
    const float sky = (p.sky.x + p.sky.y + p.sky.z) / 3.0f;
    store_rgba(&image.radiance[4 * texel], exact ? 0.5f * (p.radiance[0] + p.radiance[1]) : p.radiance[0], 1.0f - sky);
    store_rgba(&image.transmittance[4 * texel], p.transmittance, 1.0f);
    if (exact) image.half_difference[texel] = 0.5f * (p.radiance[0] - p.radiance[1]);
  }
}

}  // namespace sideray::rt
