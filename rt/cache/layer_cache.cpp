#include "rt/cache/layer_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/base/half_bits.h"
#include "rt/base/view_rays.h"
#include "rt/cache/older_layers.h"
#include "rt/layers/frame_tiles.h"

namespace sideray::rt {
namespace {

constexpr float least_distance = std::numeric_limits<float>::min();  // because 0 marks an empty layer
constexpr float rounding = 0x1p-21f;  // of positions, as a share of the distance

void clear_whole(const CacheRequest& request, LayerCache& cache) {
  const size_t texels = request.whole_pixels ? 4 * size_t{request.width} * request.height : 0;
  if (cache.whole_transmittance.size() == texels) return;
  cache.whole_radiance.assign(texels, 0);
  cache.whole_transmittance.assign(texels, 0);
}

// Returns whether a ray that hit a triangle passes its edges, as seen along the ray, by more than `near` in world
// units.
bool is_off_edges(const ShadingScene& scene, const Hit& hit, const Ray& ray, float near) {
  const model::Instance& instance = scene.snapshot->instances[hit.instance];
  const model::Mesh& mesh = *scene.snapshot->meshes[instance.mesh];
  const glm::uvec3 t = mesh.triangles[hit.primitive];
  const glm::mat3 linear(instance.local_from_object);
  const auto seen = [&](glm::vec3 edge) {
    const glm::vec3 e = linear * edge;
    return e - ray.direction * glm::dot(e, ray.direction);
  };
  const glm::vec3 e1 = seen(mesh.positions[t.y] - mesh.positions[t.x]);
  const glm::vec3 e2 = seen(mesh.positions[t.z] - mesh.positions[t.x]);
  const float area = glm::length(glm::cross(e1, e2));
  return hit.u * area > near * glm::length(e2) && hit.v * area > near * glm::length(e1) &&
         (1.0f - hit.u - hit.v) * area > near * glm::length(e2 - e1);
}

}  // namespace

uint32_t counted_surfaces(const CacheRequest& r, uint32_t x, uint32_t y) {
  const bool bytes = r.mask == SIDERAY_MASK_TEXTURE || r.mask == SIDERAY_MASK_MEMORY;
  uint32_t stencil = 0;
  if (!bytes || r.others_bits != 0) stencil = read_depth(r.depth, x, y).stencil;
  if ((stencil & r.others_bits) != 0) return 0;
  const uint32_t saturated = bytes ? 0xff : r.stencil_bits;
  const uint32_t count = bytes ? r.mask_bytes[size_t{y} * r.width + x] : stencil & saturated;
  return count == saturated ? 0 : count;
}

void begin_cache(const CacheRequest& request, const std::vector<uint8_t>& tiles, const std::vector<uint8_t>& traced,
                 Executor& executor, LayerCache& cache) {
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
  clear_whole(request, cache);
  mark_tiles(fresh, tiles, traced, cache.traced_tiles, cache.dirty_tiles);
  for_tile_rows(request.width, request.height, cache.dirty_tiles, executor, [&](size_t first, uint32_t count) {
    for (size_t layer = 0; layer < request.max_layers; ++layer) {
      const size_t texel = layer * plane + first;
      std::fill_n(cache.radiance.begin() + static_cast<ptrdiff_t>(4 * texel), 4 * size_t{count}, uint16_t{0});
      std::fill_n(cache.distance.begin() + static_cast<ptrdiff_t>(texel), count, 0.0f);
      std::fill_n(cache.surface_id.begin() + static_cast<ptrdiff_t>(texel), count, 0u);
    }
    if (request.whole_pixels)
      std::fill_n(cache.whole_transmittance.begin() + static_cast<ptrdiff_t>(4 * first), 4 * size_t{count}, uint16_t{0});
  });
}

void WholePixels::begin(const CacheRequest& request, const ShadingScene& scene, std::vector<Pixel>& later) {
  request_ = &request;
  scene_ = &scene;
  later_ = &later;
}

void WholePixels::begin(std::span<const PixelRequest> pixels) {
  pixels_.resize(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    pixels_[i].texel = pixels[i].y * request_->width + pixels[i].x;
    pixels_[i].met = 0;
    pixels_[i].sure = true;
    pixels_[i].filtered = false;
    pixels_[i].transmittance = glm::vec3(1.0f);
  }
}

void WholePixels::meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met) {
  const shading::SrBlend blend = blend_of(point);
  Pixel& p = pixels_[pixel];
  ++p.met;
  p.covers[met.layer] = blend.cover;
  p.weights[met.layer] = blend.through;
  // A vertex may move along both x and y; twice the subpixel step exceeds the sum.
  const float near = 2.0f * request_->subpixel * point.cone.width + rounding * static_cast<float>(met.hit.distance);
  const bool sways = scene_->snapshot->instances[met.hit.instance].wind != 0;
  p.sure = p.sure && !sways && is_off_edges(*scene_, met.hit, met.ray, near);
}

// Surfaces may arrive out of order, so attenuation is computed at the end.
void WholePixels::weigh(Pixel& pixel) {
  for (uint32_t layer = 0; layer < pixel.met; ++layer) {
    const glm::vec3 through = pixel.weights[layer];
    pixel.weights[layer] = pixel.transmittance * pixel.covers[layer];
    pixel.transmittance *= through;
  }
}

void WholePixels::end(std::span<const PixelRequest> pixels, LayerCache& cache) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    Pixel& p = pixels_[i];
    if (!p.sure || p.met == 0 || p.met != counted_surfaces(*request_, pixels[i].x, pixels[i].y)) continue;
    weigh(p);
    if (p.filtered)
      later_->push_back(p);
    else
      composite_whole(p, cache);
  }
}

void composite_whole(const WholePixels::Pixel& pixel, LayerCache& cache) {
  const size_t plane = size_t{cache.width} * cache.height;
  glm::vec3 sum(0.0f);
  for (uint32_t layer = 0; layer < pixel.met; ++layer) {
    const uint16_t* halfs = &cache.radiance[4 * (layer * plane + pixel.texel)];
    sum += pixel.weights[layer] * glm::vec3(imath_half_to_float(halfs[0]), imath_half_to_float(halfs[1]),
                                            imath_half_to_float(halfs[2]));
  }
  store_rgba(&cache.whole_radiance[size_t{4} * pixel.texel], sum, 1.0f);
  store_rgba(&cache.whole_transmittance[size_t{4} * pixel.texel], pixel.transmittance, 1.0f);
}

void CacheSink::begin(std::span<const PixelRequest> pixels) {
  pixels_ = pixels;
  if (older_) older_->clear(pixels, cache_);
  if (whole_) whole_->begin(pixels);
}

void CacheSink::expect(uint32_t pixel, uint32_t layer) {
  const size_t texel = (size_t{layer} * cache_.height + pixels_[pixel].y) * cache_.width + pixels_[pixel].x;
  __builtin_prefetch(&cache_.radiance[4 * texel], 1);
  __builtin_prefetch(&cache_.distance[texel], 1);
  __builtin_prefetch(&cache_.surface_id[texel], 1);
}

bool CacheSink::meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3&) {
  if (whole_) whole_->meet(pixel, point, met);
  return true;
}

void CacheSink::resolve(uint32_t pixel, uint32_t layer) {
  const PixelRequest& p = pixels_[pixel];
  float& distance = cache_.distance[(size_t{layer} * cache_.height + p.y) * cache_.width + p.x];
  distance = -std::abs(distance);
  if (whole_) whole_->refuse(pixel);
}

void CacheSink::end(std::span<const PixelRequest> pixels) {
  if (whole_) whole_->end(pixels, cache_);
}

void CacheSink::add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3) {
  const PixelRequest& p = pixels_[pixel];
  const size_t texel = (size_t{layer} * cache_.height + p.y) * cache_.width + p.x;
  store_rgba(&cache_.radiance[4 * texel], *radiance, 1.0f);
  cache_.distance[texel] = std::max(static_cast<float>(hit.distance), least_distance);
  cache_.surface_id[texel] = snapshot_.instances[hit.instance].surface_id;
  if (older_) older_->record(texel, geometric_normal(snapshot_, hit));
}

void CacheSink::add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                          const RoughReflection& rough) {
  if (!rough_) return;
  if (whole_) whole_->filter(pixel);
  const PixelRequest& p = pixels_[pixel];
  const uint32_t in_picture = p.y * cache_.width + p.x;
  const uint32_t texel = layer * cache_.height * cache_.width + in_picture;
  rough_->add(in_picture, texel, cache_.surface_id[texel], point, radiance, rough);
}

}  // namespace sideray::rt
