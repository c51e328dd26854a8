// Composites a frame's surfaces as CompositeSink does, but resolves surfaces that bend light (RefractingSink) and
// filters rough reflections over the picture before it adds them. The sinks of different chunks write different texels
// and may run at the same time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/cache/layer_filter.h"
#include "rt/composite/composite_image.h"
#include "rt/layers/layer_tracer.h"

namespace sideray::rt {

// Holds the radiance of each pixel's first rough surfaces until it is filtered, and the chunks' pixels that wait for
// it.
class FilteredSurfaces {
 public:
  static constexpr uint32_t most = 2;  // filtered surfaces a pixel; those behind keep their noise
  struct Pixel {
    uint32_t texel;
    uint32_t surfaces;
    glm::vec3 rest;  // radiance of everything else
    std::array<glm::vec3, most> weights;
  };

  // A rough surface of a pixel, which has this number among its rough surfaces, and the radiance from one direction.
  struct Rough {
    uint32_t pixel, number, surface_id;
    const SurfacePoint& point;
    glm::vec3 radiance;
    const RoughReflection& reflection;
  };

  // Resets for a frame. `filters` false: nothing is filtered.
  void begin(uint32_t width, uint32_t height, size_t chunks, bool filters);
  bool filters() const { return !waiting_.empty(); }
  void add(size_t chunk, const Rough& rough);
  void wait(size_t chunk, const Pixel& pixel) { waiting_[chunk].push_back(pixel); }
  // Filters, and stores the waiting pixels.
  void finish(Executor& executor, CompositeImage& image);

 private:
  LayerFilter filter_;
  LayerCache shown_;  // only its radiance is used
  std::vector<std::vector<Pixel>> waiting_;  // by chunk
};

class FilteredSink final : public LayerSink {
 public:
  struct Pixel {
    static constexpr uint32_t most_told = 8;  // surfaces whose weights are stored in case they are rough
    glm::vec3 radiance, transmittance;
    std::array<glm::vec3, most_told> weights;
    uint32_t rough;                                       // rough surfaces that wait for the filter
    std::array<uint32_t, FilteredSurfaces::most> layers;  // their numbers along the ray
  };
  // The arguments must outlive the sink. `bends` is as in FrameContext.
  FilteredSink(const model::Snapshot& snapshot, std::span<const uint8_t> bends, size_t chunk, FilteredSurfaces& surfaces,
               std::vector<Pixel>& scratch, CompositeImage& image)
      : snapshot_(snapshot), bends_(bends), chunk_(chunk), surfaces_(surfaces), pixels_(scratch), image_(image) {}
  void begin(std::span<const PixelRequest> pixels) override;
  bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) override;
  void add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) override;
  void add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                 const RoughReflection& rough) override;
  bool finished(uint32_t pixel) const override;
  void end(std::span<const PixelRequest> pixels) override;

 private:
  uint32_t texel_of(const PixelRequest& p) const { return p.y * image_.width + p.x; }

  const model::Snapshot& snapshot_;
  std::span<const uint8_t> bends_;
  size_t chunk_;
  FilteredSurfaces& surfaces_;
  std::vector<Pixel>& pixels_;
  CompositeImage& image_;
  std::span<const PixelRequest> requests_;
};

}  // namespace sideray::rt
