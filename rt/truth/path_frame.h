// Holds the state of one path through each pixel of a picture (RefractionTracer::find_ends), and the ends of the
// pixels' straight rays. It points to itself and must not move.
#pragma once

#include <vector>

#include "rt/layers/frame_context.h"
#include "rt/refraction/refraction_tracer.h"

namespace sideray::rt {

class PathFrame {
 public:
  // The caller keeps all arguments alive. `view` must be made from `trace_view`.
  PathFrame(const TraceView& trace_view, const ViewRays& view, uint32_t width, uint32_t height, const ShadingScene& scene,
            const Intersector& intersector, const RefractionScene& refraction)
      : ends_(size_t{width} * height) {
    layers_.view = trace_view;
    layers_.width = width, layers_.height = height;
    frame_ = {.request = &layers_,
              .view = &view,
              .scene = &scene,
              .intersector = &intersector,
              .set = LayerSet::all_translucent,
              .ends = ends_.data()};
    context_ = refraction_context(frame_, refraction, true);
  }
  PathFrame(const PathFrame&) = delete;
  PathFrame& operator=(const PathFrame&) = delete;

  // Ends the pixel's straight ray at the first opaque surface, if it hits one. Different threads may set different
  // pixels.
  void end_ray(const PixelRequest& p, const Ray& ray, const Hit& opaque) {
    ends_[size_t{p.y} * layers_.width + p.x] = opaque.instance == no_instance
                                                   ? ray.t_far
                                                   : static_cast<float>(opaque.distance) * (1.0f - on_opaque_surface);
  }
  const RefractionContext& context() const { return context_; }

 private:
  std::vector<float> ends_;  // of the straight rays, one a texel
  LayerRequest layers_;
  FrameContext frame_{};
  RefractionContext context_{};
};

}  // namespace sideray::rt
