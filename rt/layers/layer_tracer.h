// Traces the translucent surfaces of a chunk of pixels, shades them in batches, and passes them on in ray order. It has
// scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/counters.h"
#include "rt/base/pixels.h"
#include "rt/base/trace_end.h"
#include "rt/base/view_rays.h"
#include "rt/layers/frame_context.h"
#include "rt/layers/layer_request.h"
#include "rt/layers/layer_steps.h"
#include "rt/shading/point_shader.h"
#include "rt/shading/ray_reuse.h"

namespace sideray::rt {

// Names a hit and its ray; `layer` is the surface's number on the pixel's ray, from 0.
struct RayHit {
  const Hit& hit;
  const Ray& ray;
  uint32_t layer = 0;
};

// Receives the surfaces of a chunk's pixels. `pixel` is the index within the chunk.
class LayerSink {
 public:
  virtual ~LayerSink() = default;
  virtual void begin(std::span<const PixelRequest> pixels) = 0;
  // Is called before a pixel's next surface is made and shaded.
  virtual void expect(uint32_t /*pixel*/, uint32_t /*layer*/) {}
  // Receives a pixel's next surface and the ray that hit it. Sets `weight`, which is passed on to add(). Returns
  // whether the surface must be shaded and add() called.
  virtual bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) = 0;
  // Receives the surface's light later, in as many estimates as the shader makes. `layer` counts the pixel's surfaces
  // from 0.
  virtual void add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) = 0;
  // Is called after add() for rough surfaces, with the same radiance and the part of it from a random direction.
  virtual void add_rough(uint32_t /*pixel*/, uint32_t /*layer*/, const SurfacePoint&, glm::vec3 /*radiance*/,
                         const RoughReflection&) {}
  // Is called if an added layer is resolved: its light includes everything behind it.
  virtual void resolve(uint32_t /*pixel*/, uint32_t /*layer*/) {}
  // Returns whether the surfaces hit so far hide everything behind them.
  virtual bool finished(uint32_t pixel) const = 0;
  virtual void end(std::span<const PixelRequest> pixels) = 0;
};

// Adds the shader's work since `before` to the counters.
void add_work(const ShaderWork& after, const ShaderWork& before, Counters& counters);

class LayerTracer {
 public:
  // `shader` must have begun. Adds the work of shader and tracer to `counters`. Returns other than complete if the
  // shader stopped early; then the sink has what was shaded before.
  TraceEnd trace(const FrameContext& frame, std::span<const PixelRequest> pixels, PointShader& shader, LayerSink& sink,
                 Counters& counters);

 private:
  struct PixelState {
    Ray ray;
    Cone cone;
    LayerStep step;
    uint32_t wanted, found;
    uint32_t key;  // for random numbers
  };
  struct Event {
    uint32_t pixel, layer;
    Hit hit;
  };

  void start(std::span<const PixelRequest> pixels);
  void aim(std::span<const PixelRequest> pixels, PixelState* states);
  void traverse_active();
  void traverse_group(uint32_t layers);
  void take_hits(uint32_t pixel, const Hit* hits, uint32_t count, uint32_t layers);
  bool is_next(const Hit& last, const Hit& hit) const;
  bool accepted(const Hit& hit) const;
  bool bends(const Hit& hit) const;
  bool is_given_up() const { return shader_->end != TraceEnd::complete; }
  void shade_events();
  RayReuse::Pixel place_of(const Event& event) const;
  void order_events();
  void gather_points();
  bool add_sprite(const Event& event, const SurfacePoint& point, glm::vec3 weight);
  void keep_wanted();
  std::span<const RoughReflection> shade_points();

  const FrameContext* frame_ = nullptr;
  PointShader* shader_ = nullptr;
  LayerSink* sink_ = nullptr;
  Counters* counters_ = nullptr;
  const ShadeKernels* kernels_ = nullptr;
  RayReuse reuse_;
  std::vector<RayReuse::Pixel> shaded_pixels_;  // pixels of shaded_, for reuse_
  std::span<const PixelRequest> requests_;
  std::vector<PixelState> states_;
  std::vector<uint32_t> active_, next_active_, group_;
  std::vector<uint32_t> layers_;  // of each active pixel: how many surfaces the next traversal looks for
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<uint32_t> hit_counts_;
  std::vector<Event> events_;
  std::vector<HitPlace> places_;
  std::vector<SurfacePoint> made_points_;  // never shrinks, because clearing points would cost as much as making some
  std::span<SurfacePoint> points_;
  std::vector<Event> shaded_;  // the events of points_
  std::vector<glm::vec3> weights_, radiance_;
};

}  // namespace sideray::rt
