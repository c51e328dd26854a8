#include "bridge/jobs/light_job.h"

#include "bridge/base/local_view.h"

namespace sideray::bridge {

rt::LightRequest light_request(const JobFrame& frame, const TraceInput& input, std::span<const rt::OpaquePoint> points,
                               bool denoise, rt::StillFrames& still) {
  const FrameInputs& in = frame.inputs;
  return {.view = local_view(in.view, frame.snapshot.origin),
          .width = static_cast<uint32_t>(in.source.width),
          .height = static_cast<uint32_t>(in.source.height),
          .depth = input.depth,
          .subpixel = input.subpixel,
          .points = points,
          .shadows = in.shadows,
          .denoise = denoise,
          .seed = in.seed,
          .position = in.inspection.position,
          .sequence = frame.sequence,
          .frame = input.frame,
          .still = &still,
          .cancelled = &input.cancelled,
          .work = input.work,
          .shading_queue = input.shading_queue,
          .wanted = in.inspection.wanted_light.get()};
}

std::vector<rt::OpaquePoint> exact_points(const JobFrame& frame, const TraceInput& input) {
  const FrameInputs& in = frame.inputs;
  if (!in.exact_points) return {};
  return input.tracer.trace_points(local_view(in.view, frame.snapshot.origin), static_cast<uint32_t>(in.source.width),
                                   static_cast<uint32_t>(in.source.height));
}

}  // namespace sideray::bridge
