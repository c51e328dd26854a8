#include "bridge/jobs/masks/mask_job.h"

#include <sideray/diagnostics.h>

#include <cmath>

#include "bridge/base/local_view.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

void check_request(const sideray_mask_inputs& in) {
  if (in.shadow_lights == 0 && in.ao_rays == 0 && !in.combined_lights)
    fail(SIDERAY_INVALID_ARGUMENT,
         "masks: none is requested; ask for shadow_lights, combined_lights or ao_rays, or give no masks");
  if (!(in.shadow_bias >= 0.0f) || !std::isfinite(in.shadow_bias))
    fail(SIDERAY_INVALID_ARGUMENT, "masks shadow_bias {}: give a finite length of 0 or more", in.shadow_bias);
  if (!(in.shadow_bias_steps >= 0.0f) || !std::isfinite(in.shadow_bias_steps))
    fail(SIDERAY_INVALID_ARGUMENT, "masks shadow_bias_steps {}: give a finite number of steps, 0 or more",
         in.shadow_bias_steps);
  if (!(in.least_light >= 0.0f) || !std::isfinite(in.least_light))
    fail(SIDERAY_INVALID_ARGUMENT, "masks least_light {}: give a finite radiance of 0 or more", in.least_light);
  if (in.unhidden_sky && in.ao_rays == 0)
    fail(SIDERAY_INVALID_ARGUMENT, "masks unhidden_sky: is found by ambient occlusion rays; give ao_rays too, or 0");
}

void check_inexact(const sideray_mask_inputs& in, const sideray_frame_source& source) {
  if (in.inexact < SIDERAY_EXACT || in.inexact > SIDERAY_INEXACT_ORIGIN)
    fail(SIDERAY_INVALID_ARGUMENT, "masks inexact {}: give a sideray_inexact", static_cast<int>(in.inexact));
  if (in.inexact_bits > 0xff || (reads_stencil_mask(source) && (in.inexact_bits & source.stencil_bits)))
    fail(SIDERAY_INVALID_ARGUMENT, "masks inexact_bits {:#x}: give bits up to 0xff outside stencil_bits",
         in.inexact_bits);
  if (in.inexact == SIDERAY_INEXACT_RESTPOSE && in.inexact_bits != 0 && in.rest_texture == 0)
    fail(SIDERAY_INVALID_ARGUMENT, "masks inexact: the rest pose needs rest_texture; give one or another test");
}

bool reads_motion(const FrameInputs& inputs) {
  return inputs.masks->denoise && inputs.continues;
}

}  // namespace

void MaskJob::check(const gl::Functions&, const FrameInputs& inputs, const model::Snapshot&) const {
  check_request(*inputs.masks);
  check_inexact(*inputs.masks, inputs.source);
}

bool MaskJob::reads_stencil(const FrameInputs& inputs) const {
  return inputs.masks->inexact != SIDERAY_EXACT && inputs.masks->inexact_bits != 0;
}

TextureReads MaskJob::texture_reads(const FrameInputs& inputs) const {
  return {{{"masks rest_texture", inputs.masks->rest_texture, rgba_floats},
           {"motion_texture", reads_motion(inputs) ? inputs.source.motion_texture : 0, rg_floats}}};
}

// Leaves half of the time to layers.
double MaskJob::share_of_time(const FrameInputs& inputs) const {
  return inputs.layers ? 0.5 : 1.0;
}

rt::Counters MaskJob::trace(const JobFrame& frame, const TraceInput& input) {
  const FrameInputs& in = frame.inputs;
  const rt::TraceView view = local_view(in.view, frame.snapshot.origin);
  const auto width = static_cast<uint32_t>(in.source.width), height = static_cast<uint32_t>(in.source.height);
  std::vector<rt::OpaquePoint> points;
  if (in.exact_points) points = input.tracer.trace_points(view, width, height);
  rt::MaskRequest request(*in.masks);
  request.view = view;
  request.width = width, request.height = height;
  request.depth = input.depth;
  request.subpixel = input.subpixel;
  request.rest_offsets = input.texels<glm::vec4>(0);
  request.points = points;
  request.hit_distances = in.inspection.hit_distances;
  request.filters = in.masks->denoise ? &filters_ : nullptr;
  request.sequence = frame.sequence;
  request.position_frames = in.inspection.position_frames;
  // A position of a still view under a budget has every mask traced for it, and is not shown before all are.
  const bool of_position = request.position_frames > 0, was_whole = request.position_frames > 1 && older_.is_complete();
  if (of_position) kept_.forget();
  request.kept = of_position ? nullptr : &kept_;
  request.redraw_keeps = in.inspection.keeps_masks;
  request.motion = input.texels<glm::vec2>(1);
  request.seed = in.seed;
  request.cancelled = &input.cancelled;
  request.work = input.work;
  request.frame = input.frame;
  request.older = &older_;
  request.wanted = in.inspection.wanted_light.get();
  looks_back_ = rt::has_older(request);
  const rt::Counters counters = input.tracer.trace_masks(request, image_);
  shows_ = !of_position || (older_.is_complete() && !was_whole);
  if (!input.cancelled) return counters;
  filters_ = {};  // no frame follows this one
  older_.forget();
  kept_.forget();
  return counters;
}

void MaskJob::prepare(const gl::Functions& gl, const JobFrame&) {
  textures_.prepare(gl, image_);
}

// Returns whether the texture already has a reused mask: if an upload fails, the next frame reuses none.
bool MaskJob::is_held(uint32_t layer) const {
  return kept_.keeps(layer) && !kept_.brings_back();
}

uint64_t MaskJob::upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) {
  if (!shows_) return 0;
  lacks_some_ = !image_.answers.empty();
  const auto held = [this](uint32_t layer) { return is_held(layer); };
  return textures_.upload(gl, image_, held, frame.inputs.inspection.wanted_light.get(), way);
}

void MaskJob::publish(const JobFrame& frame) {
  const sideray_frame_source& source = frame.inputs.source;
  const sideray_mask_inputs& in = *frame.inputs.masks;
  outputs_ = {.size = sizeof(outputs_),
              .ticket = frame.ticket,
              .view = frame.inputs.view,
              .x = source.x,
              .y = source.y,
              .width = source.width,
              .height = source.height,
              .shadow_texture = textures_.shadow(),
              .shadow_lights = in.shadow_lights,
              .combined_lights = in.combined_lights != 0,
              .ao_texture = textures_.ambient(),
              .unhidden_sky = in.unhidden_sky != 0,
              .tint_texture = 0,
              .tint_layers = {},
              .depth_texture = textures_.depth(),
              .answer_texture = lacks_some_ ? textures_.answers() : 0};
  depth_step_ = image_.depth_step;
  const std::vector<uint32_t> lights = rt::lights_of(in.shadow_lights);
  for (uint32_t layer = 0; layer < rt::light_masks_of(in.shadow_lights, in.combined_lights != 0) && image_.tints > 0; ++layer) {
    const uint32_t place = image_.tint_places[layer];
    if (place == 0 || !image_.is_tinted(place)) continue;
    outputs_.tint_texture = textures_.tint();
    outputs_.tint_layers[layer < lights.size() ? lights[layer] : 32] = static_cast<int32_t>(3 * (place - 1) + 1);
  }
}

glm::vec2 MaskJob::depth_error(const rt::FrameCamera& camera) const {
  const double range = camera.zero_to_one ? 1.0 : 2.0;
  const auto error = static_cast<float>(std::abs(camera.depth_terms.z) * range * double{depth_step_});
  return camera.perspective ? glm::vec2(error, 0.0f) : glm::vec2(0.0f, error);
}

void MaskJob::abandon() {
  textures_.abandon();
  kept_.forget();
  outputs_ = {};
}

}  // namespace sideray::bridge
