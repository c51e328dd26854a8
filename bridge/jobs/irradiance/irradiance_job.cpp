#include "bridge/jobs/irradiance/irradiance_job.h"

#include "bridge/base/local_view.h"
#include "model/stopwatch.h"

namespace sideray::bridge {

rt::Counters IrradianceJob::trace(const JobFrame& frame, const TraceInput& input) {
  const FrameInputs& in = frame.inputs;
  const rt::TraceView view = local_view(in.view, frame.snapshot.origin);
  const auto width = static_cast<uint32_t>(in.source.width), height = static_cast<uint32_t>(in.source.height);
  std::vector<rt::OpaquePoint> points;
  if (in.exact_points) points = input.tracer.trace_points(view, width, height);
  const rt::IrradianceRequest request{.view = view,
                                      .width = width,
                                      .height = height,
                                      .depth = input.depth,
                                      .subpixel = input.subpixel,
                                      .points = points,
                                      .shadows = in.shadows,
                                      .denoise = in.irradiance->denoise != 0,
                                      .seed = in.seed,
                                      .sequence = frame.sequence,
                                      .still = &still_,
                                      .history = in.irradiance->denoise != 0 ? &history_ : nullptr,
                                      .position_frames = in.inspection.position_frames,
                                      .cancelled = &input.cancelled,
                                      .work = input.work,
                                      .shading_queue = input.shading_queue,
                                      .wanted = in.inspection.wanted_light.get()};
  const Stopwatch watch;
  rt::Counters counters = input.tracer.trace_irradiance(request, image_);
  counters.trace_ms = watch.ms() - counters.denoise_ms;
  if (!input.cancelled) return counters;
  still_.forget();
  history_.forget();
  return counters;
}

void IrradianceJob::prepare(const gl::Functions& gl, const JobFrame&) {
  texture_.prepare(gl, light());
}

uint64_t IrradianceJob::upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) {
  return image_.changed ? texture_.upload(gl, light(), frame.inputs.inspection.wanted_light.get(), way) : 0;
}

void IrradianceJob::publish(const JobFrame& frame) {
  const sideray_frame_source& source = frame.inputs.source;
  outputs_ = {.size = sizeof(outputs_),
              .ticket = frame.ticket,
              .view = frame.inputs.view,
              .x = source.x,
              .y = source.y,
              .width = source.width,
              .height = source.height,
              .irradiance_texture = texture_.id()};
}

void IrradianceJob::abandon() {
  still_.forget();
  texture_.abandon();
  outputs_ = {};
}

}  // namespace sideray::bridge
