#include "bridge/base/check_inputs.h"

#include <bit>
#include <cmath>

#include "bridge/base/local_view.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

bool reads_stencil_mask(const sideray_frame_inputs& in) {
  return in.mask == SIDERAY_MASK_STENCIL || in.mask == SIDERAY_MASK_COUNT;
}

void check_target(const sideray_frame_inputs& in) {
  if (in.width < 1 || in.height < 1 || in.width > 16384 || in.height > 16384 || in.x < 0 || in.y < 0)
    fail(SIDERAY_INVALID_ARGUMENT,
         "frame rectangle {}x{} at {},{}: sides must be 1 to 16384 and the corner not negative", in.width, in.height,
         in.x, in.y);
  if (in.depth_texture != 0 && in.depth_renderbuffer != 0)
    fail(SIDERAY_INVALID_ARGUMENT, "frame depth_texture: there is a depth_renderbuffer too; give one of them");
}

void check_mask(const sideray_frame_inputs& in) {
  if (in.mask < SIDERAY_MASK_NONE || in.mask > SIDERAY_MASK_MEMORY)
    fail(SIDERAY_INVALID_ARGUMENT, "frame mask {}: give a sideray_mask_source", static_cast<int>(in.mask));
  const bool contiguous = in.stencil_bits != 0 && in.stencil_bits <= 0xff && std::has_single_bit(in.stencil_bits + 1);
  if (reads_stencil_mask(in) && !contiguous)
    fail(SIDERAY_INVALID_ARGUMENT, "frame stencil_bits {:#x}: must be contiguous from bit 0, 0x1 to 0xff",
         in.stencil_bits);
  if (in.mask == SIDERAY_MASK_TEXTURE && in.mask_texture == 0)
    fail(SIDERAY_INVALID_ARGUMENT, "frame mask_texture: 0; give the R8 texture that holds the mask");
  if (in.mask == SIDERAY_MASK_MEMORY && (!in.mask_texels || in.mask_row_bytes < static_cast<size_t>(in.width)))
    fail(SIDERAY_INVALID_ARGUMENT, "frame mask_texels: NULL, or rows of less than {} bytes; give a byte for each pixel",
         in.width);
}

void check_occlusion(const sideray_frame_inputs& in) {
  if (in.inexact < SIDERAY_EXACT || in.inexact > SIDERAY_INEXACT_ORIGIN)
    fail(SIDERAY_INVALID_ARGUMENT, "frame inexact {}: give a sideray_inexact", static_cast<int>(in.inexact));
  if (in.denoise_on < SIDERAY_DENOISE_AUTO || in.denoise_on > SIDERAY_DENOISE_GPU)
    fail(SIDERAY_INVALID_ARGUMENT, "frame denoise_on {}: give a sideray_denoise_on", static_cast<int>(in.denoise_on));
  if (in.inexact_bits > 0xff || (reads_stencil_mask(in) && (in.inexact_bits & in.stencil_bits)))
    fail(SIDERAY_INVALID_ARGUMENT, "frame inexact_bits {:#x}: give bits up to 0xff outside stencil_bits",
         in.inexact_bits);
  if (in.inexact == SIDERAY_INEXACT_RESTPOSE && in.inexact_bits != 0 && in.rest_texture == 0)
    fail(SIDERAY_INVALID_ARGUMENT, "frame inexact: the rest pose needs rest_texture; give one or another test");
  if (in.layers_off && in.shadow_lights == 0 && in.ao_rays == 0 && in.reflection_normals == 0)
    fail(SIDERAY_INVALID_ARGUMENT,
         "frame layers_off: then nothing is traced; ask for shadow_lights, ao_rays or reflection_normals");
  if (in.reflection_normals != 0 && !(in.reflection_max_roughness >= 0.0f && in.reflection_max_roughness <= 1.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "frame reflection_max_roughness {}: give 0 to 1", in.reflection_max_roughness);
}

void check_encoding(const sideray_frame_inputs& in) {
  if (in.radiance_format < SIDERAY_RADIANCE_RGBA16F || in.radiance_format > SIDERAY_RADIANCE_RGB9E5)
    fail(SIDERAY_INVALID_ARGUMENT, "frame radiance_format {}: give a sideray_radiance_format",
         static_cast<int>(in.radiance_format));
  if (in.radiance_space < SIDERAY_SPACE_LINEAR || in.radiance_space > SIDERAY_SPACE_GAMMA22)
    fail(SIDERAY_INVALID_ARGUMENT, "frame radiance_space {}: give a sideray_radiance_space",
         static_cast<int>(in.radiance_space));
  if (!(in.radiance_scale > 0.0f) || !std::isfinite(in.radiance_scale))
    fail(SIDERAY_INVALID_ARGUMENT, "frame radiance_scale {}: give a finite factor above 0", in.radiance_scale);
  const bool encodes = in.radiance_space != SIDERAY_SPACE_LINEAR || in.radiance_scale != 1.0f;
  if (in.mode == SIDERAY_COMPOSITE && encodes)
    fail(SIDERAY_INVALID_ARGUMENT,
         "frame radiance_space: a composite is linear radiance with a scale of 1; encode it where it is drawn");
}

void check_layers(const sideray_frame_inputs& in) {
  if (in.cache_rate < SIDERAY_RATE_FULL || in.cache_rate > SIDERAY_RATE_TEMPORAL8)
    fail(SIDERAY_INVALID_ARGUMENT, "frame cache_rate {}: give a sideray_cache_rate", static_cast<int>(in.cache_rate));
  if (in.layers_off) return;
  if (in.mode == SIDERAY_CACHE ? in.max_layers < 1 || in.max_layers > 8 : in.max_layers > 64)
    fail(SIDERAY_INVALID_ARGUMENT, "frame max_layers {}: give {}", in.max_layers,
         in.mode == SIDERAY_CACHE ? "1 to 8" : "1 to 64, or 0 for unlimited");
  if (in.match < SIDERAY_MATCH_ID || in.match > SIDERAY_MATCH_DISTANCE)
    fail(SIDERAY_INVALID_ARGUMENT, "frame match {}: give a sideray_match", static_cast<int>(in.match));
  if (in.step < SIDERAY_STEP_MULTIHIT || in.step > SIDERAY_STEP_LISTING)
    fail(SIDERAY_INVALID_ARGUMENT, "frame step {}: give a sideray_step", static_cast<int>(in.step));
  if (!(in.match_threshold > 0.0f) || !std::isfinite(in.match_threshold))
    fail(SIDERAY_INVALID_ARGUMENT, "frame match_threshold {}: give a finite share of the distance above 0",
         in.match_threshold);
  if (!(in.layer_threshold >= 0.0f) || !std::isfinite(in.layer_threshold))
    fail(SIDERAY_INVALID_ARGUMENT, "frame layer_threshold {}: give a finite radiance of 0 or more", in.layer_threshold);
  if (in.layer_threshold > 0.0f && in.mode == SIDERAY_COMPOSITE && in.refraction)
    fail(SIDERAY_INVALID_ARGUMENT, "frame layer_threshold {}: bent rays are all traced; leave it or refraction out",
         in.layer_threshold);
  check_encoding(in);
}

}  // namespace

void check_inputs(const sideray_frame_inputs& in) {
  check_target(in);
  check_mask(in);
  check_occlusion(in);
  check_layers(in);
  if (!(in.deadline_ms >= 0.0f) || !std::isfinite(in.deadline_ms))
    fail(SIDERAY_INVALID_ARGUMENT, "frame deadline_ms {}: give finite milliseconds, or 0 for none", in.deadline_ms);
  if (in.state_policy < SIDERAY_SAVE_AND_RESTORE || in.state_policy > SIDERAY_HOST_RESTORES)
    fail(SIDERAY_INVALID_ARGUMENT, "frame state_policy {}: give a sideray_state_policy",
         static_cast<int>(in.state_policy));
  check_view_id(in.view_id);
  check_view(in.view);
}

void check_view_id(uint32_t id) {
  if (id >= SIDERAY_MAX_VIEWS) fail(SIDERAY_INVALID_ARGUMENT, "view_id {}: give 0 to {}", id, SIDERAY_MAX_VIEWS - 1);
}

gl::StatePolicy policy_of(const sideray_frame_inputs& in) {
  return in.state_policy == SIDERAY_HOST_RESTORES ? gl::StatePolicy::leave : gl::StatePolicy::restore;
}

void check_shader(const sideray_frame_inputs& in, const sideray_shader_desc& shader) {
  if (!shader.shade || in.layers_off) return;
  if (in.layer_threshold > 0.0f)
    fail(SIDERAY_INVALID_ARGUMENT,
         "frame layer_threshold {}: the scene has a shader of the host, which nothing bounds; give 0",
         in.layer_threshold);
  if (in.mode == SIDERAY_COMPOSITE && in.particles)
    fail(
        SIDERAY_INVALID_ARGUMENT,
        "frame particles: the scene has a shader of the host, which sprites are not for; leave them to the rasterizer");
}

void check_capabilities(const gl::Functions& gl, const sideray_frame_inputs& in) {
  if (in.denoise && in.denoise_on == SIDERAY_DENOISE_GPU && gl.version < 33)
    fail(SIDERAY_UNSUPPORTED,
         "frame denoise_on: masks are filtered on the device from OpenGL 3.3 on, this is \"{}\"; filter on the CPU",
         gl.version_string);
  if (in.radiance_format == SIDERAY_RADIANCE_RGB9E5 && !gl.shared_exponent)
    fail(SIDERAY_UNSUPPORTED, "frame radiance_format: {} has no RGB9_E5 textures (OpenGL 3.0 or {}); use RGBA16F",
         gl.renderer, "EXT_texture_shared_exponent");
}

bool has_masks(const sideray_frame_inputs& in) {
  return (in.shadow_lights != 0 || in.ao_rays != 0) && in.adds_to == 0;
}

bool has_reflections(const sideray_frame_inputs& in) {
  return in.reflection_normals != 0 && in.adds_to == 0;
}

}  // namespace sideray::bridge
