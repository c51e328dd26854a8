#include "rt/layers/layer_cache.h"

#include <algorithm>
#include <limits>

#include "rt/base/half_bits.h"
#include "rt/layers/frame_tiles.h"

namespace sideray::rt {
namespace {

constexpr uint16_t half_one = 0x3c00;
constexpr float least_distance = std::numeric_limits<float>::min();  // 0 is an empty layer

}  // namespace

void begin_cache(const CacheRequest& request, const std::vector<uint8_t>& tiles, Executor& executor,
                 LayerCache& cache) {
  if (request.requested_bits != 0) {
    cache.dirty_tiles = tiles;
    for (size_t i = 0; i < tiles.size(); ++i) cache.traced_tiles[i] |= tiles[i];
    return;
  }
  const bool fresh = cache.width != request.width || cache.height != request.height ||
                     cache.layers != request.max_layers || cache.traced_tiles.size() != tiles.size();
  const size_t plane = size_t{request.width} * request.height, texels = plane * request.max_layers;
  if (fresh) {
    cache.width = request.width;
    cache.height = request.height;
    cache.layers = request.max_layers;
    cache.radiance.resize(4 * texels);
    cache.distance.resize(texels);
    cache.surface_id.resize(texels);
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

}  // namespace sideray::rt
