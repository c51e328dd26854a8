// Fills a layer cache with what the frame before knows, and lets the rest be shaded. A sink belongs to one thread; as with
// CacheSink, the sinks of different chunks may run at the same time.
#pragma once

#include "rt/cache/layer_cache.h"
#include "rt/cache/temporal_history.h"

namespace sideray::rt {

// Fills a layer cache at a temporal rate.
class TemporalSink final : public LayerSink {
 public:
  // The history must have begun.
  TemporalSink(LayerCache& cache, const model::Snapshot& snapshot, LayerHistory& history, LayerFilter::Chunk* rough,
               OlderLayers* older)
      : cache_(cache), cache_sink_(cache, snapshot, rough, nullptr, older), history_(history) {}
  void begin(std::span<const PixelRequest> pixels) override;
  bool knows(uint32_t pixel, uint32_t layer, const Hit& hit, const Ray& ray) override;
  bool meet(uint32_t, const SurfacePoint&, const RayHit&, glm::vec3&) override { return true; }
  void add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) override;
  void add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                 const RoughReflection& rough) override {
    cache_sink_.add_rough(pixel, layer, point, radiance, rough);
  }
  void resolve(uint32_t pixel, uint32_t layer) override { cache_sink_.resolve(pixel, layer); }
  bool finished(uint32_t) const override { return false; }
  void end(std::span<const PixelRequest> pixels) override { cache_sink_.end(pixels); }

 private:
  LayerCache& cache_;
  CacheSink cache_sink_;
  LayerHistory& history_;
  std::span<const PixelRequest> pixels_;
};

// Fills a layer cache at the full rate, and takes over the light that the frame before knows where it has not changed. The
// shaded layers show where it has.
class ReusingSink final : public LayerSink {
 public:
  // The history must have begun. `whole` as for CacheSink; `view` is the frame's.
  ReusingSink(LayerCache& cache, const model::Snapshot& snapshot, const ViewRays& view, LayerHistory& history,
              LayerFilter::Chunk* rough, WholePixels* whole, OlderLayers* older)
      : cache_(cache), cache_sink_(cache, snapshot, rough, whole, older), view_(view), history_(history), filters_(rough) {}
  void begin(std::span<const PixelRequest> pixels) override;
  bool knows(uint32_t pixel, uint32_t layer, const Hit& hit, const Ray& ray) override;
  bool knows_bent(uint32_t pixel, uint32_t layer, const Hit& hit, const Ray& ray) override {
    return knows(pixel, layer, hit, ray);
  }
  bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) override;
  void add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) override;
  void add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                 const RoughReflection& rough) override;
  void resolve(uint32_t pixel, uint32_t layer) override { cache_sink_.resolve(pixel, layer); }
  bool finished(uint32_t) const override { return false; }
  void end(std::span<const PixelRequest> pixels) override;

  uint64_t reused = 0;  // layers taken over

 private:
  LayerCache& cache_;
  CacheSink cache_sink_;
  const ViewRays& view_;
  LayerHistory& history_;
  bool filters_;
  std::span<const PixelRequest> pixels_;
};

}  // namespace sideray::rt
