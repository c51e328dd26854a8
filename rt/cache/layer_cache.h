// Stores a frame's layers in the layer cache, after clearing the tiles of the previous frame. One thread calls
// begin_cache; the sinks of different chunks write different texels and may run at the same time.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/cache/layer_filter.h"
#include "rt/layers/layer_tracer.h"

namespace sideray::rt {

// Resizes the cache, clears the tiles traced in the last frame and those about to be traced, and marks both as dirty. A
// second wave clears nothing and marks only its own tiles. `traced`: tiles with traced pixels; other tiles are left as
// they are. Empty: all.
void begin_cache(const CacheRequest& request, const std::vector<uint8_t>& tiles, const std::vector<uint8_t>& traced,
                 Executor& executor, LayerCache& cache);

// Returns how many surfaces the mask counts at a pixel; 0 = there is no count, or it leaves out some drawn surfaces.
uint32_t counted_surfaces(const CacheRequest& request, uint32_t x, uint32_t y);

// Finds the whole pixels of a chunk: those whose rays hit as many surfaces as the mask counts, each so far from its
// triangle's edges that the rasterizer is sure to draw it too. Then both have the same surfaces, and the pixel can be
// composited along its ray. Scratch memory: one object a thread.
class WholePixels {
 public:
  static constexpr uint32_t most_layers = 8;
  struct Pixel {
    uint32_t texel;  // of the picture
    uint32_t met = 0;
    bool sure = true, filtered = false;
    glm::vec3 transmittance{1.0f};
    std::array<glm::vec3, most_layers> weights;  // weights of the layers' radiance; before end(), their transmittance
    std::array<float, most_layers> covers;
  };

  // Pixels with a layer that is filtered later go to `later` and not into the cache.
  void begin(const CacheRequest& request, const ShadingScene& scene, std::vector<Pixel>& later);
  void begin(std::span<const PixelRequest> pixels);
  void meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met);
  void filter(uint32_t pixel) { pixels_[pixel].filtered = true; }
  // Makes the pixel not whole, so that fragments look its layers up.
  void refuse(uint32_t pixel) { pixels_[pixel].sure = false; }
  void end(std::span<const PixelRequest> pixels, LayerCache& cache);

 private:
  static void weigh(Pixel& pixel);

  const CacheRequest* request_ = nullptr;
  const ShadingScene* scene_ = nullptr;
  std::vector<Pixel>* later_ = nullptr;
  std::vector<Pixel> pixels_;
};

// Composites a whole pixel from its layers in the cache.
void composite_whole(const WholePixels::Pixel& pixel, LayerCache& cache);

class CacheSink final : public LayerSink {
 public:
  // `rough` receives the layers to filter; null: none are. `whole` must have begun; null: no pixel is whole. `older`
  // receives the surfaces; null: there is no history, and the cache is empty at the chunk's pixels.
  CacheSink(LayerCache& cache, const model::Snapshot& snapshot, LayerFilter::Chunk* rough, WholePixels* whole,
            OlderLayers* older)
      : cache_(cache), snapshot_(snapshot), rough_(rough), whole_(whole), older_(older) {}
  void begin(std::span<const PixelRequest> pixels) override;
  // Prefetches the memory of the layer's light.
  void expect(uint32_t pixel, uint32_t layer) override;
  bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) override;
  void add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) override;
  void add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                 const RoughReflection& rough) override;
  void resolve(uint32_t pixel, uint32_t layer) override;
  bool finished(uint32_t) const override { return false; }
  void end(std::span<const PixelRequest> pixels) override;

 private:
  LayerCache& cache_;
  const model::Snapshot& snapshot_;
  LayerFilter::Chunk* rough_;
  WholePixels* whole_;
  OlderLayers* older_;
  std::span<const PixelRequest> pixels_;
};

}  // namespace sideray::rt
