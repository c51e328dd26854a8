// The part of the service that traces what opaque surfaces mirror.
#include "bridge/base/local_view.h"
#include "bridge/service/service.h"

namespace sideray::bridge {

void Service::trace_reflections(Frame& frame) {
  const sideray_frame_inputs& in = frame.inputs;
  const std::vector<rt::OpaquePoint> points = exact_points(frame);
  const rt::ReflectionRequest request{.view = local_view(in.view, frame.snapshot->origin),
                                      .width = static_cast<uint32_t>(in.width),
                                      .height = static_cast<uint32_t>(in.height),
                                      .depth = frame.depth,
                                      .subpixel = subpixel_,
                                      .normals = frame.readback.reflection_normals(),
                                      .points = points,
                                      .max_roughness = in.reflection_max_roughness,
                                      .shadows = in.shadows != 0,
                                      .denoise = in.denoise != 0,
                                      .seed = in.seed,
                                      .cancelled = &frame.cancelled,
                                      .deadline = frame.deadline,
                                      .shading_queue = queue_of(frame)};
  const Clock::time_point start = Clock::now();
  const rt::TraceCounters counters = tracer_->tracer.trace_reflections(request, frame.view->reflections);
  frame.stats.denoise_ms += counters.denoise_ms;
  frame.stats.trace_ms += std::chrono::duration<double, std::milli>(Clock::now() - start).count() - counters.denoise_ms;
  frame.stats.rays_reflection += counters.rays_reflection;
  frame.stats.rays_shadow += counters.rays_shadow;
  frame.stats.points_shaded += counters.points_shaded;
  frame.stats.points_not_finite += counters.points_not_finite;
  frame.stats.pixels_total = counters.pixels_total;
}

}  // namespace sideray::bridge
