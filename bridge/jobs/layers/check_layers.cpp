#include "bridge/jobs/layers/check_layers.h"

#include <sideray/diagnostics.h>

#include <cmath>

#include "bridge/base/frame_inputs.h"
#include "bridge/base/lighting.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

void check_choices(const sideray_layer_inputs& in) {
  if (in.mode < SIDERAY_CACHE || in.mode > SIDERAY_COMPOSITE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers mode {}: give a sideray_service_mode", static_cast<int>(in.mode));
  if (in.cache_rate < SIDERAY_RATE_FULL || in.cache_rate > SIDERAY_RATE_TEMPORAL8)
    fail(SIDERAY_INVALID_ARGUMENT, "layers cache_rate {}: give a sideray_cache_rate", static_cast<int>(in.cache_rate));
  if (in.match < SIDERAY_MATCH_ID || in.match > SIDERAY_MATCH_DISTANCE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers match {}: give a sideray_match", static_cast<int>(in.match));
  if (in.step < SIDERAY_STEP_MULTIHIT || in.step > SIDERAY_STEP_LISTING)
    fail(SIDERAY_INVALID_ARGUMENT, "layers step {}: give a sideray_step", static_cast<int>(in.step));
}

void check_numbers(const sideray_layer_inputs& in) {
  if (in.mode == SIDERAY_CACHE ? in.max_layers < 1 || in.max_layers > 8 : in.max_layers > 64)
    fail(SIDERAY_INVALID_ARGUMENT, "layers max_layers {}: give {}", in.max_layers,
         in.mode == SIDERAY_CACHE ? "1 to 8" : "1 to 64, or 0 for unlimited");
  if (!(in.match_threshold > 0.0f) || !std::isfinite(in.match_threshold))
    fail(SIDERAY_INVALID_ARGUMENT, "layers match_threshold {}: give a finite share of the distance above 0",
         in.match_threshold);
  if (!(in.ray_reuse >= 0.0f) || !std::isfinite(in.ray_reuse))
    fail(SIDERAY_INVALID_ARGUMENT, "layers ray_reuse {}: give a finite radiance of 0 or more", in.ray_reuse);
  if (in.ray_reuse == 0.0f) return;
  if (in.mode == SIDERAY_CACHE && in.cache_rate != SIDERAY_RATE_FULL)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers ray_reuse {}: at a reduced or temporal rate layers are taken over already; give FULL, or 0",
         in.ray_reuse);
}

void check_shading_reuse(const sideray_layer_inputs& in) {
  if (!(in.shading_reuse >= 0.0f) || !std::isfinite(in.shading_reuse))
    fail(SIDERAY_INVALID_ARGUMENT, "layers shading_reuse {}: give a finite radiance of 0 or more", in.shading_reuse);
  if (in.shading_reuse == 0.0f) return;
  if (in.mode != SIDERAY_CACHE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers shading_reuse {}: a composite keeps no layers; give 0", in.shading_reuse);
  if (in.cache_rate != SIDERAY_RATE_FULL)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers shading_reuse {}: at a reduced or temporal rate layers are taken over already; give FULL, or 0",
         in.shading_reuse);
}

void check_reference_samples(const sideray_layer_inputs& in) {
  if (in.light_samples == 0) return;
  if (in.mode != SIDERAY_COMPOSITE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers light_samples {}: a cache holds no reference; give COMPOSITE, or 0",
         in.light_samples);
  check_lighting(in.light_samples, in.bounces);
}

void check_refraction(const sideray_layer_inputs& in) {
  if (!in.refraction) return;
  if (in.mode == SIDERAY_CACHE) return;
  if (in.ray_reuse > 0.0f)
    fail(SIDERAY_INVALID_ARGUMENT, "layers ray_reuse {}: refracted rays are all traced; leave it or refraction out",
         in.ray_reuse);
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
  check_shading_reuse(in);
  check_reference_samples(in);
  check_refraction(in);
  check_encoding(in);
}

void check_whole_pixels(const sideray_frame_source& source, const sideray_layer_inputs& in) {
  if (!in.whole_pixels) return;
  if (in.mode != SIDERAY_CACHE)
    fail(SIDERAY_INVALID_ARGUMENT, "layers whole_pixels: a composite holds every pixel already; leave it out");
  if (source.mask == SIDERAY_MASK_NONE || source.mask == SIDERAY_MASK_STENCIL)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers whole_pixels: the mask does not count surfaces, so that it is unknown whether the cache holds all of "
         "them; give SIDERAY_MASK_COUNT, or counts in a texture or in memory");
  if (in.cache_rate != SIDERAY_RATE_FULL || in.adds_to != 0)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers whole_pixels: at a reduced or temporal rate layers are taken over from elsewhere; give FULL");
  if (in.radiance_space != SIDERAY_SPACE_LINEAR || in.radiance_scale != 1.0f)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers whole_pixels: they are linear radiance with a scale of 1; give radiance_space LINEAR and a scale of 1");
  if (in.others_bits > 0xff || (reads_stencil_mask(source) && (in.others_bits & source.stencil_bits)))
    fail(SIDERAY_INVALID_ARGUMENT, "layers others_bits {:#x}: give 0 to 0xff, outside stencil_bits", in.others_bits);
}

void check_layer_shader(const sideray_layer_inputs& in, const sideray_shader_desc& shader) {
  if (!shader.shade) return;
  if (in.ray_reuse > 0.0f)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers ray_reuse {}: the scene has a shader of the host, which says itself what its light is; give 0",
         in.ray_reuse);
  if (in.shading_reuse > 0.0f)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers shading_reuse {}: the scene has a shader of the host, which says itself what its light is; give 0",
         in.shading_reuse);
  if (in.light_samples > 0)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers light_samples {}: the scene has a shader of the host, which says itself what its light is; give 0",
         in.light_samples);
  if (in.whole_pixels)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers whole_pixels: the scene has a shader of the host, whose covers are unknown; give 0");
  if (in.mode == SIDERAY_COMPOSITE && in.particles)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers particles: the scene has a shader of the host, which sprites are not for; leave them to the "
         "rasterizer");
}

}  // namespace sideray::bridge
