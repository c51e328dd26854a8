#include "rt/cache/temporal_sink.h"

#include <algorithm>

namespace sideray::rt {
namespace {

// Returns whether so much of a layer's light is from one random direction that each frame needs its own, which the filter
// takes the noise out of: what was filtered with older light would keep its noise.
bool is_noisy(const SurfacePoint& point, const RoughReflection& rough) {
  constexpr float most_kept_roughness = 0.1f, most_kept_weight = 0.1f;
  const float weight = std::max({rough.weight.x, rough.weight.y, rough.weight.z}) * point.blended.cover;
  return rough.through || rough.roughness > most_kept_roughness || weight > most_kept_weight;
}

}  // namespace

void TemporalSink::begin(std::span<const PixelRequest> pixels) {
  pixels_ = pixels;
  cache_sink_.begin(pixels);
  for (const PixelRequest& p : pixels) history_.clear(p);
}

bool TemporalSink::knows(uint32_t pixel, uint32_t layer, const Hit& hit, const Ray& ray) {
  const PixelRequest& p = pixels_[pixel];
  if (history_.is_shaded_anew(p.x, p.y)) return false;
  const std::optional<LayerHistory::Layer> known = history_.find(hit, ray);
  if (!known) return false;
  cache_sink_.store(pixel, layer, hit, known->radiance);
  history_.record(p, layer, *known);
  return true;
}

void TemporalSink::add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) {
  cache_sink_.add(pixel, layer, hit, radiance, weight);
  const PixelRequest& p = pixels_[pixel];
  const size_t texel = (size_t{layer} * cache_.height + p.y) * cache_.width + p.x;
  LayerHistory::Layer stored{.radiance = {}, .distance = cache_.distance[texel], .surface_id = cache_.surface_id[texel]};
  std::copy_n(&cache_.radiance[4 * texel], 3, stored.radiance);
  history_.record(p, layer, stored);
}

void ReusingSink::begin(std::span<const PixelRequest> pixels) {
  pixels_ = pixels;
  cache_sink_.begin(pixels);
  for (const PixelRequest& p : pixels) history_.clear(p);
}

bool ReusingSink::knows(uint32_t pixel, uint32_t layer, const Hit& hit, const Ray& ray) {
  cache_sink_.knows(pixel, layer, hit, ray);
  const PixelRequest& p = pixels_[pixel];
  const Cone cone = view_.cone(p.x, p.y);
  const float footprint = cone.width + cone.spread * static_cast<float>(hit.distance);
  const std::optional<LayerHistory::Past> past = history_.past(hit, ray, footprint);
  if (!past) return false;
  if (!past->keeps || history_.is_shaded_anew(p.x, p.y)) {
    if (past->stands) history_.expect(p, layer, past->layer);
    return false;
  }
  cache_sink_.store(pixel, layer, hit, past->layer.radiance);
  cache_sink_.meet_known(pixel, past->layer.blend, footprint, {hit, ray, layer});
  history_.record(p, layer, past->layer);
  ++reused;
  return true;
}

bool ReusingSink::meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) {
  history_.record(pixels_[pixel], met.layer,
                  {.radiance = {},
                   .distance = static_cast<float>(met.hit.distance),
                   .surface_id = 0,
                   .front = met.hit.front,
                   .position = met.ray.origin + met.ray.direction * static_cast<float>(met.hit.distance),
                   .blend = blend_of(point)});
  return cache_sink_.meet(pixel, point, met, weight);
}

void ReusingSink::add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) {
  cache_sink_.add(pixel, layer, hit, radiance, weight);
  const PixelRequest& p = pixels_[pixel];
  const size_t texel = (size_t{layer} * cache_.height + p.y) * cache_.width + p.x;
  LayerHistory::Layer& stored = history_.recorded(p, layer);
  stored.surface_id = cache_.surface_id[texel];
  std::copy_n(&cache_.radiance[4 * texel], 3, stored.radiance);
}

void ReusingSink::add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                            const RoughReflection& rough) {
  cache_sink_.add_rough(pixel, layer, point, radiance, rough);
  if (!filters_) return;
  LayerHistory::Layer& stored = history_.recorded(pixels_[pixel], layer);
  stored.noisy = stored.noisy || is_noisy(point, rough);
  history_.leave_to_filter(pixels_[pixel], layer);
}

void ReusingSink::end(std::span<const PixelRequest> pixels) {
  cache_sink_.end(pixels);
  for (const PixelRequest& p : pixels) history_.compare(p);
}

}  // namespace sideray::rt
