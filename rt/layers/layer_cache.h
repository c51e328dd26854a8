// Stores a frame's answers in the layer cache, which forgets the tiles of the frame before. One thread calls
// begin_cache; the sinks of different chunks write different texels and may run at the same time.
#pragma once

#include "rt/base/executor.h"
#include "rt/layers/layer_filter.h"
#include "rt/layers/layer_tracer.h"

namespace sideray::rt {

// Sizes the target, clears the tiles traced in the last frame and those about to be, and marks both as dirty. A second
// wave keeps what the cache holds, and marks its own tiles alone.
void begin_cache(const CacheRequest& request, const std::vector<uint8_t>& tiles, Executor& executor, LayerCache& cache);

class CacheSink final : public LayerSink {
 public:
  // `rough` receives what is to be filtered; null: nothing is filtered.
  CacheSink(LayerCache& cache, const model::Snapshot& snapshot, LayerFilter::Chunk* rough)
      : cache_(cache), snapshot_(snapshot), rough_(rough) {}
  void begin(std::span<const PixelRequest> pixels) override { pixels_ = pixels; }
  bool meet(uint32_t, const SurfacePoint&, glm::vec3&) override { return true; }
  void add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) override;
  void add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                 const RoughReflection& rough) override;
  bool finished(uint32_t) const override { return false; }
  void end(std::span<const PixelRequest>) override {}
  // Stores a radiance that is known as halfs.
  void store(uint32_t pixel, uint32_t layer, const Hit& hit, const uint16_t radiance[3]);

 private:
  LayerCache& cache_;
  const model::Snapshot& snapshot_;
  LayerFilter::Chunk* rough_;
  std::span<const PixelRequest> pixels_;
};

}  // namespace sideray::rt
