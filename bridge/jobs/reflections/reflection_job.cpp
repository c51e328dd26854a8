#include "bridge/jobs/reflections/reflection_job.h"

#include "bridge/base/local_view.h"
#include "model/failure.h"
#include "model/stopwatch.h"

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
  const FrameInputs& in = frame.inputs;
  const rt::TraceView view = local_view(in.view, frame.snapshot.origin);
  const auto width = static_cast<uint32_t>(in.source.width), height = static_cast<uint32_t>(in.source.height);
  std::vector<rt::OpaquePoint> points;
  if (in.exact_points) points = input.tracer.trace_points(view, width, height);
  const rt::ReflectionRequest request{.view = view,
                                      .width = width,
                                      .height = height,
                                      .depth = input.depth,
                                      .subpixel = input.subpixel,
                                      .normals = input.are_halfs[0] ? rt::NormalTexels(input.texels<uint16_t>(0))
                                                                    : rt::NormalTexels(input.texels<glm::vec4>(0)),
                                      .points = points,
                                      .max_roughness = in.reflections->max_roughness,
                                      .error = in.layers ? in.layers->ray_reuse : 0.0f,
                                      .shadows = in.shadows,
                                      .denoise = in.reflections->denoise != 0,
                                      .light_bounces = in.irradiance.has_value(),
                                      .seed = in.seed,
                                      .sequence = frame.sequence,
                                      .still = &still_,
                                      .cancelled = &input.cancelled,
                                      .work = input.work,
                                      .older = &older_,
                                      .shading_queue = input.shading_queue,
                                      .wanted = in.inspection.wanted_light.get()};
  const Stopwatch watch;
  rt::Counters counters = input.tracer.trace_reflections(request, image_);
  counters.trace_ms = watch.ms() - counters.denoise_ms;
  if (!input.cancelled) return counters;
  still_.forget();
  older_.forget();
  return counters;
}

void ReflectionJob::prepare(const gl::Functions& gl, const JobFrame&) {
  texture_.prepare(gl, light());
}

uint64_t ReflectionJob::upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) {
  return image_.changed ? texture_.upload(gl, light(), frame.inputs.inspection.wanted_light.get(), way) : 0;
}

void ReflectionJob::publish(const JobFrame& frame) {
  const sideray_frame_source& source = frame.inputs.source;
  outputs_ = {.size = sizeof(outputs_),
              .ticket = frame.ticket,
              .view = frame.inputs.view,
              .x = source.x,
              .y = source.y,
              .width = source.width,
              .height = source.height,
              .reflection_texture = texture_.id()};
}

void ReflectionJob::abandon() {
  still_.forget();
  texture_.abandon();
  outputs_ = {};
}

}  // namespace sideray::bridge
