#include "bridge/jobs/layers/check_layers.h"

#include <sideray/diagnostics.h>

#include <cmath>

#include "bridge/base/frame_inputs.h"
#include "bridge/base/lighting.h"
#include "bridge/base/reuse.h"
#include "bridge/base/whole_pixels.h"
#include "model/failure.h"
#include "rt/layers/layer_request.h"

namespace sideray::bridge {
namespace {

void check_choices(const sideray_layer_inputs& in) {
  if (in.mode < SIDERAY_CACHE || in.mode > SIDERAY_COMPOSITE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers mode {}: give a sideray_service_mode", static_cast<int>(in.mode));
  if (in.cache_rate < SIDERAY_RATE_FULL || in.cache_rate > SIDERAY_RATE_QUARTER)
    fail(SIDERAY_INVALID_ARGUMENT, "layers cache_rate {}: give a sideray_cache_rate", static_cast<int>(in.cache_rate));
  if (in.match < SIDERAY_MATCH_ID || in.match > SIDERAY_MATCH_DISTANCE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers match {}: give a sideray_match", static_cast<int>(in.match));
  if (in.step < SIDERAY_STEP_MULTIHIT || in.step > SIDERAY_STEP_LISTING)
    fail(SIDERAY_INVALID_ARGUMENT, "layers step {}: give a sideray_step", static_cast<int>(in.step));
}

void check_numbers(const sideray_layer_inputs& in) {
  const uint32_t least = in.mode == SIDERAY_CACHE ? 1 : 0;
  const uint32_t most = in.mode == SIDERAY_CACHE ? rt::most_cached_layers : rt::most_composited_layers;
  if (in.max_layers < least || in.max_layers > most)
    fail(SIDERAY_INVALID_ARGUMENT, "layers max_layers {}: give 1 to {}{}", in.max_layers, most,
         in.mode == SIDERAY_CACHE ? "" : ", or 0 for unlimited");
  if (!(in.match_threshold > 0.0f) || !std::isfinite(in.match_threshold))
    fail(SIDERAY_INVALID_ARGUMENT, "layers match_threshold {}: give a finite share of the distance above 0",
         in.match_threshold);
}

void check_reuse(const sideray_layer_inputs& in, const LayerUse& use) {
  if (!(in.ray_reuse >= 0.0f) || !std::isfinite(in.ray_reuse))
    fail(SIDERAY_INVALID_ARGUMENT, "layers ray_reuse {}: give a finite radiance of 0 or more", in.ray_reuse);
  if (const char* reason = why_no_ray_reuse(use); reason && in.ray_reuse > 0.0f)
    fail(SIDERAY_INVALID_ARGUMENT, "layers ray_reuse {}: {}; give 0", in.ray_reuse, reason);
}

void check_reference_samples(const sideray_layer_inputs& in) {
  if (in.light_samples == 0) return;
  if (in.mode != SIDERAY_COMPOSITE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers light_samples {}: a cache holds no reference; give COMPOSITE, or 0",
         in.light_samples);
  check_lighting(in.light_samples, in.bounces);
}

void check_encoding(const sideray_layer_inputs& in) {
  if (in.radiance_space < SIDERAY_SPACE_LINEAR || in.radiance_space > SIDERAY_SPACE_GAMMA22)
    fail(SIDERAY_INVALID_ARGUMENT, "layers radiance_space {}: give a sideray_radiance_space",
         static_cast<int>(in.radiance_space));
  if (!(in.radiance_scale > 0.0f) || !std::isfinite(in.radiance_scale))
    fail(SIDERAY_INVALID_ARGUMENT, "layers radiance_scale {}: give a finite factor above 0", in.radiance_scale);
  const bool encodes = in.radiance_space != SIDERAY_SPACE_LINEAR || in.radiance_scale != 1.0f;
  if (in.mode == SIDERAY_COMPOSITE && encodes)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers radiance_space: a composite is linear radiance with a scale of 1; encode it where it is drawn");
}

}  // namespace

void check_layers(const sideray_layer_inputs& in) {
  check_choices(in);
  check_numbers(in);
  check_reuse(in, use_of(in, false));
  check_reference_samples(in);
  check_encoding(in);
}

void check_whole_pixels(const sideray_frame_source& source, const sideray_layer_inputs& in, bool host_shades) {
  if (!in.whole_pixels) return;
  if (in.mode != SIDERAY_CACHE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers whole_pixels: a composite holds every pixel already; leave it out");
  const bool counts = source.mask != SIDERAY_MASK_NONE && source.mask != SIDERAY_MASK_STENCIL;
  if (const NoWholePixels none = no_whole_pixels(counts, in.cache_rate, host_shades); none.reason)
    fail(SIDERAY_INVALID_ARGUMENT, "layers whole_pixels: {}; give 0, or another {}", none.reason, none.option);
  if (in.adds_to != 0)
    fail(SIDERAY_INVALID_ARGUMENT, "layers whole_pixels: a second wave adds layers to pixels that are not whole; give 0");
  if (in.radiance_space != SIDERAY_SPACE_LINEAR || in.radiance_scale != 1.0f)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers whole_pixels: they are linear radiance with a scale of 1; give radiance_space LINEAR and a scale of 1");
  if (in.others_bits > 0xff || (reads_stencil_mask(source) && (in.others_bits & source.stencil_bits)))
    fail(SIDERAY_INVALID_ARGUMENT, "layers others_bits {:#x}: give 0 to 0xff, outside stencil_bits", in.others_bits);
}

void check_fixed_layers(const sideray_layer_inputs& in) {
  if (in.light_samples > 0)
    fail(SIDERAY_INVALID_ARGUMENT, "layers light_samples {}: the fixed function has no lights with sizes; give 0",
         in.light_samples);
}

void check_layer_shader(const sideray_layer_inputs& in) {
  check_reuse(in, use_of(in, true));
  if (in.light_samples > 0)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers light_samples {}: the scene has a shader of the host, which says itself what its light is; give 0",
         in.light_samples);
  if (in.particles)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers particles: the scene has a shader of the host, which sprites are not for; leave them to the "
         "rasterizer");
}

}  // namespace sideray::bridge
