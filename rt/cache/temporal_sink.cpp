#include "rt/cache/temporal_sink.h"

#include <algorithm>

namespace sideray::rt {

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
  LayerHistory::Layer stored{{}, cache_.distance[texel], cache_.surface_id[texel]};
  std::copy_n(&cache_.radiance[4 * texel], 3, stored.radiance);
  history_.record(p, layer, stored);
}

}  // namespace sideray::rt
