#include "bridge/jobs/reflections/reflection_job.h"

#include "model/failure.h"

namespace sideray::bridge {

void ReflectionJob::check(const gl::Functions&, const FrameInputs& inputs, const model::Snapshot&) const {
  const sideray_reflection_inputs& in = *inputs.reflections;
  if (in.normal_texture == 0)
    fail(SIDERAY_INVALID_ARGUMENT,
         "reflections normal_texture: 0; give the texture that holds normals and roughness, or no reflections");
  if (!(in.max_roughness >= 0.0f && in.max_roughness <= 1.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "reflections max_roughness {}: give 0 to 1", in.max_roughness);
}

TextureReads ReflectionJob::texture_reads(const FrameInputs& inputs) const {
  return {{{"reflections normal_texture", inputs.reflections->normal_texture, rgba_floats_or_halfs}}};
}

rt::Counters ReflectionJob::trace(const JobFrame& frame, const TraceInput& input) {
  const sideray_reflection_inputs& in = *frame.inputs.reflections;
  const std::vector<rt::OpaquePoint> points = exact_points(frame, input);
  rt::ReflectionRequest request{light_request(frame, input, points, in.denoise != 0, still_)};
  request.normals = input.are_halfs[0] ? rt::NormalTexels(input.texels<uint16_t>(0))
                                       : rt::NormalTexels(input.texels<glm::vec4>(0));
  request.max_roughness = in.max_roughness;
  request.error = frame.inputs.layers ? frame.inputs.layers->ray_reuse : 0.0f;
  request.light_bounces = frame.inputs.irradiance.has_value();
  request.older = &history_;
  looks_back_ = rt::is_bounded(request.work);
  return fill(input, [&] { return input.tracer.trace_reflections(request, image_); });
}

}  // namespace sideray::bridge
