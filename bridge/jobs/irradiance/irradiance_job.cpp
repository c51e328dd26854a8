#include "bridge/jobs/irradiance/irradiance_job.h"

namespace sideray::bridge {

rt::Counters IrradianceJob::trace(const JobFrame& frame, const TraceInput& input) {
  const std::vector<rt::OpaquePoint> points = exact_points(frame, input);
  const bool denoise = frame.inputs.irradiance->denoise != 0;
  rt::IrradianceRequest request{light_request(frame, input, points, denoise, still_)};
  request.history = denoise ? &history_ : nullptr;
  request.position_frames = frame.inputs.inspection.position_frames;
  return fill(input, [&] { return input.tracer.trace_irradiance(request, image_); });
}

}  // namespace sideray::bridge
