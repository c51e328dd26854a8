// Resolves layers of surfaces that bend light. It is between a tracer of straight rays, which end there, and the sink
// that stores layers. Light behind such a surface is found along refracted rays after the chunk's other layers are
// shaded, and becomes part of its layer, which then hides everything behind it. A sink belongs to one thread and one
// chunk.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/layers/layer_tracer.h"
#include "rt/refraction/refraction_tracer.h"

namespace sideray::rt {

// Keeps a thread's memory between chunks.
struct RefractingScratch {
  static constexpr uint32_t none = 0xffffffffu;
  // Holds the part of a refracting surface's layer that straight rays compute.
  struct Layer {
    uint32_t pixel;
    float cover;
    uint32_t layer = none;
    uint32_t rough = none;  // index of its rough reflection
    uint32_t point = none;  // index of the surface, if the light behind it may be blurred
    glm::vec3 radiance{0.0f}, weight{0.0f};
  };
  struct Rough {
    SurfacePoint point;
    RoughReflection reflection;
  };

  RefractionTracer tracer;
  std::vector<FirstBend> bends;
  std::vector<Layer> layers;  // of bends[]
  std::vector<Rough> rough;
  std::vector<SurfacePoint> points;
  std::vector<uint32_t> bend_of;  // by pixel: index of its bend, or none
  std::vector<RefractedPixel> seen;
};

class RefractingSink final : public LayerSink {
 public:
  // The arguments must outlive the sink. `context` is for refracted rays; `counters` receives their work.
  RefractingSink(LayerSink& straight, const RefractionContext& context, PointShader& shader, RefractingScratch& scratch,
                 Counters& counters)
      : straight_(straight), context_(context), shader_(shader), scratch_(scratch), counters_(counters) {}
  void begin(std::span<const PixelRequest> pixels) override;
  void expect(uint32_t pixel, uint32_t layer) override { straight_.expect(pixel, layer); }
  bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) override;
  void add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) override;
  void add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                 const RoughReflection& rough) override;
  bool finished(uint32_t pixel) const override { return straight_.finished(pixel); }
  void end(std::span<const PixelRequest> pixels) override;

 private:
  bool bends(const Hit& hit) const;
  void resolve_layer(const RefractingScratch::Layer& layer, const Hit& hit, const RefractedPixel& seen);

  LayerSink& straight_;
  const RefractionContext& context_;
  PointShader& shader_;
  RefractingScratch& scratch_;
  Counters& counters_;
  std::span<const PixelRequest> pixels_;
};

}  // namespace sideray::rt
