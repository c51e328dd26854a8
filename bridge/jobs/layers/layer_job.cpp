#include "bridge/jobs/layers/layer_job.h"

#include <cmath>

#include "bridge/base/local_view.h"
#include "bridge/jobs/layers/check_layers.h"
#include "model/failure.h"
#include "model/stopwatch.h"

namespace sideray::bridge {
namespace {

bool caches(const FrameInputs& inputs) {
  return inputs.layers->mode == SIDERAY_CACHE;
}

// Omits transfer function and scale for a host's shader and the fixed function: they return the host's own space.
LayerEncoding encoding_of(const gl::Functions& gl, const JobFrame& frame) {
  const sideray_layer_inputs& in = *frame.inputs.layers;
  LayerEncoding encoding{.float_ids = in.float_ids != 0 || !gl.integer_textures};
  if (frame.snapshot.shader.shade || frame.snapshot.fixed) return encoding;
  encoding.space = in.radiance_space;
  encoding.scale = in.radiance_scale;
  return encoding;
}

}  // namespace

void LayerJob::check(const gl::Functions&, const FrameInputs& inputs, const model::Snapshot& snapshot) const {
  check_layers(*inputs.layers);
  if (is_second_wave(inputs)) check_second_wave(inputs);
  const bool host_shades = snapshot.shader.shade != nullptr;
  check_whole_pixels(inputs.source, *inputs.layers, host_shades);
  if (host_shades) check_layer_shader(*inputs.layers);
  if (snapshot.fixed) check_fixed_layers(*inputs.layers);
}

void LayerJob::check_second_wave(const FrameInputs& inputs) const {
  const sideray_layer_inputs& in = *inputs.layers;
  const sideray_frame_source& source = inputs.source;
  if (in.requested_bits == 0 || in.requested_bits > 0xff ||
      (reads_stencil_mask(source) && (in.requested_bits & source.stencil_bits)))
    fail(SIDERAY_INVALID_ARGUMENT, "layers requested_bits {:#x}: give 1 to 0xff, outside stencil_bits",
         in.requested_bits);
  if (in.adds_to != outputs_.ticket || in.adds_to != cache_ticket_)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers adds_to {}: it is not the newest finished frame of the view; wait for it, and submit its second wave "
         "before another frame",
         in.adds_to);
  const bool same = caches(inputs) && outputs_.mode == SIDERAY_CACHE && in.max_layers == outputs_.layers &&
                    in.cache_rate == lookup_.rate && source.x == outputs_.x && source.y == outputs_.y &&
                    source.width == outputs_.width && source.height == outputs_.height;
  if (!same)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers adds_to {}: mode, rectangle, max_layers or cache_rate differ from that frame's; give the same inputs",
         in.adds_to);
}

bool LayerJob::reads_stencil(const FrameInputs& inputs) const {
  const bool others = inputs.layers->whole_pixels && inputs.layers->others_bits != 0;
  return reads_stencil_mask(inputs.source) || is_second_wave(inputs) || others;
}

rt::Counters LayerJob::trace(const JobFrame& frame, const TraceInput& input) {
  const Stopwatch watch;
  rt::Counters counters = caches(frame.inputs) ? trace_cache(frame, input) : trace_composite(frame, input);
  counters.trace_ms = watch.ms() - counters.denoise_ms;
  if (frame.inputs.inspection.check && caches(frame.inputs))
    truth_ = input.tracer.trace_truth(cache_request(frame, input));
  return counters;
}

// Returns the light at the frame's opaque pixels, which was traced before; empty if it is not all of it: the frame requests
// one of the two alone, or occluders of the sky are searched nearby alone.
rt::PixelLight LayerJob::pixel_light(const FrameInputs& in) const {
  if (!in.irradiance || !in.masks || in.masks->ao_rays == 0 || std::isfinite(in.masks->ao_distance)) return {};
  const size_t pixels = static_cast<size_t>(in.source.width) * static_cast<size_t>(in.source.height);
  if (masks_.open.size() != pixels || irradiance_.light.size() != 4 * pixels) return {};
  return {irradiance_.light, masks_.open, masks_.answers, rt::OcclusionMasks::answer_of_sky};
}

// Fills the part of the request that both modes share, besides the host's inputs.
void LayerJob::fill(rt::LayerRequest& request, const JobFrame& frame, const TraceInput& input) const {
  const FrameInputs& in = frame.inputs;
  request.view = local_view(in.view, frame.snapshot.origin);
  request.width = static_cast<uint32_t>(in.source.width);
  request.height = static_cast<uint32_t>(in.source.height);
  request.depth = input.depth;
  request.mask = in.source.mask;
  request.stencil_bits = in.source.stencil_bits;
  request.mask_bytes = input.mask_bytes;
  request.shadows = in.shadows;
  request.light_bounces = in.irradiance.has_value();
  request.lit = pixel_light(in);
  request.seed = in.seed;
  request.position = in.inspection.position;
  request.cancelled = &input.cancelled;
  request.work = input.work;
  request.shading_queue = input.shading_queue;
}

rt::CacheRequest LayerJob::cache_request(const JobFrame& frame, const TraceInput& input) {
  rt::CacheRequest request(*frame.inputs.layers);
  fill(request, frame, input);
  if (!is_second_wave(frame.inputs)) request.requested_bits = 0;
  request.sequence = frame.sequence;
  request.older = &older_;
  request.position_frames = frame.inputs.inspection.position_frames;
  request.subpixel = input.subpixel;
  request.wanted = frame.inputs.inspection.wanted.get();
  return request;
}

rt::Counters LayerJob::trace_cache(const JobFrame& frame, const TraceInput& input) {
  cache_ticket_ = frame.ticket;
  rt::CacheRequest request = cache_request(frame, input);
  // Tiles are not reused in a second wave, which adds to them, nor under a deadline, which may leave out any.
  const bool may_keep = !is_second_wave(frame.inputs) && !rt::is_bounded(request.work) && !input.cancelled;
  if (may_keep)
    request.still = &still_;
  else
    still_.forget();
  looks_back_ = rt::takes_older(request);
  const rt::Counters counters = input.tracer.trace_cache(request, cache_);
  if (input.cancelled) still_.forget();
  return counters;
}

rt::Counters LayerJob::trace_composite(const JobFrame& frame, const TraceInput& input) {
  rt::LayerRequest request(*frame.inputs.layers);
  fill(request, frame, input);
  request.resolves = frame.inputs.resolves;
  return input.tracer.trace_composite(request, composite_);
}

void LayerJob::prepare(const gl::Functions& gl, const JobFrame& frame) {
  float_ids_ = encoding_of(gl, frame).float_ids;
  if (caches(frame.inputs))
    cache_textures_.prepare(gl, cache_, encoding_of(gl, frame));
  else
    composite_textures_.prepare(gl, composite_);
}

uint64_t LayerJob::upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) {
  caches_ = caches(frame.inputs);
  return caches_ ? cache_textures_.upload(gl, cache_, encoding_of(gl, frame), way)
                 : composite_textures_.upload(gl, composite_, way);
}

uint64_t LayerJob::texture_bytes() const {
  return caches_ ? cache_textures_.bytes() : composite_textures_.bytes();
}

void LayerJob::publish(const JobFrame& frame) {
  const sideray_frame_source& source = frame.inputs.source;
  const sideray_layer_inputs& in = *frame.inputs.layers;
  outputs_ = {.size = sizeof(outputs_),
              .ticket = frame.ticket,
              .mode = in.mode,
              .view = frame.inputs.view,
              .x = source.x,
              .y = source.y,
              .width = source.width,
              .height = source.height,
              .layers = caches_ ? cache_.layers : 0,
              .radiance_texture = caches_ ? cache_textures_.radiance() : composite_textures_.radiance(),
              .distance_texture = caches_ ? cache_textures_.distance() : composite_textures_.transmittance(),
              .surface_id_texture = caches_ ? cache_textures_.surface_id() : 0,
              .whole_radiance_texture = caches_ ? cache_textures_.whole_radiance() : 0,
              .whole_transmittance_texture = caches_ ? cache_textures_.whole_transmittance() : 0};
  lookup_ = {in.match, in.match_threshold, in.cache_rate, in.refraction != 0, caches_ && older_.has_moved(),
             frame.multisampled, float_ids_};
}

// Forgets unchanged tiles, since some were traced but not uploaded.
void LayerJob::give_up() {
  still_.forget();
  cache_textures_.invalidate();
  composite_textures_.invalidate();
}

void LayerJob::abandon() {
  still_.forget();
  cache_textures_.abandon();
  composite_textures_.abandon();
  outputs_ = {};
}

}  // namespace sideray::bridge
