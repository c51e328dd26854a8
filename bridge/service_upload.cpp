// The part of the service that brings traced frames into textures. First everything that can fail, then the texels: a
// frame that fails leaves the last good outputs as they are.
#include "bridge/check_inputs.h"
#include "bridge/service.h"
#include "gl/state_guard.h"

namespace sideray::bridge {
namespace {

LayerEncoding encoding_of(const gl::Functions& gl, const sideray_frame_inputs& in) {
  return {in.radiance_format, in.radiance_space, in.radiance_scale, in.float_ids != 0 || !gl.integer_textures};
}

bool filters_on_device(const sideray_frame_inputs& in) {
  return has_masks(in) && in.denoise && in.denoise_on == SIDERAY_DENOISE_GPU;
}

}  // namespace

void Service::upload(Frame& frame, const gl::ErrorGuard& errors) {
  if (timed_) gl_.Finish();
  const Clock::time_point start = Clock::now();
  prepare_upload(frame);
  errors.check("upload");
  move_texels(frame);
  if (timed_) gl_.Finish();
  frame.stats.upload_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  if (filters_on_device(frame.inputs)) denoise_masks(frame);
  frame.stats.bytes_cache = bytes_cached(frame);
  publish(frame);
  close(frame, SIDERAY_OK);
}

void Service::prepare_upload(Frame& frame) {
  const sideray_frame_inputs& in = frame.inputs;
  const gl::PixelTransferGuard transfer(gl_);
  const gl::FramebufferGuard framebuffers(gl_);
  const gl::ProgramGuard program(gl_);
  const gl::TextureGuard textures(gl_, 0, 1);
  gl_.ActiveTexture(GL_TEXTURE0);
  if (!in.layers_off && in.mode == SIDERAY_CACHE) cache_textures_.prepare(gl_, cache_, encoding_of(gl_, in));
  if (!in.layers_off && in.mode != SIDERAY_CACHE) composite_textures_.prepare(gl_, composite_);
  if (has_reflections(in)) reflection_texture_.prepare(gl_, reflections_);
  if (has_masks(in)) mask_textures_.prepare(gl_, masks_);
  if (filters_on_device(in)) mask_denoiser_.prepare(gl_, denoiser_input(frame));
}

void Service::move_texels(Frame& frame) {
  const sideray_frame_inputs& in = frame.inputs;
  const bool persistent = transport_->persistent_upload;
  const gl::PixelTransferGuard transfer(gl_);
  const gl::TextureGuard textures(gl_, 0, 1);
  gl_.ActiveTexture(GL_TEXTURE0);
  uint64_t bytes = 0;
  if (!in.layers_off)
    bytes += in.mode == SIDERAY_CACHE ? cache_textures_.upload(gl_, cache_, encoding_of(gl_, in), persistent)
                                      : composite_textures_.upload(gl_, composite_, persistent);
  if (has_reflections(in)) bytes += reflection_texture_.upload(gl_, reflections_, persistent);
  if (has_masks(in)) bytes += mask_textures_.upload(gl_, masks_, persistent);
  frame.stats.bytes_upload = bytes;
}

uint64_t Service::bytes_cached(const Frame& frame) const {
  const sideray_frame_inputs& in = frame.inputs;
  uint64_t bytes = 0;
  if (!in.layers_off) bytes += in.mode == SIDERAY_CACHE ? cache_textures_.bytes() : composite_textures_.bytes();
  if (has_reflections(in)) bytes += reflection_texture_.bytes();
  if (has_masks(in)) bytes += mask_textures_.bytes();
  return bytes;
}

void Service::publish(const Frame& frame) {
  const sideray_frame_inputs& in = frame.inputs;
  const bool masks = has_masks(in), reflections = has_reflections(in);
  const bool to_cache = !in.layers_off && in.mode == SIDERAY_CACHE, composite = !in.layers_off && !to_cache;
  const bool adds = in.adds_to != 0;  // masks stay those of the frame that it adds to
  latest_ = {.size = sizeof(latest_),
             .ticket = frame.ticket,
             .mode = in.mode,
             .view = in.view,
             .x = in.x,
             .y = in.y,
             .width = in.width,
             .height = in.height,
             .layers = to_cache ? cache_.layers : 0,
             .radiance_texture = to_cache    ? cache_textures_.radiance()
                                 : composite ? composite_textures_.radiance()
                                             : 0,
             .distance_texture = to_cache    ? cache_textures_.distance()
                                 : composite ? composite_textures_.transmittance()
                                             : 0,
             .surface_id_texture = to_cache ? cache_textures_.surface_id() : 0,
             .shadow_texture = masks && in.shadow_lights ? mask_textures_.shadow()
                               : adds                    ? latest_.shadow_texture
                                                         : 0,
             .shadow_lights = adds ? latest_.shadow_lights : in.shadow_lights,
             .ao_texture = masks && in.ao_rays ? mask_textures_.ambient()
                           : adds              ? latest_.ao_texture
                                               : 0,
             .reflection_texture = reflections ? reflection_texture_.id()
                                   : adds      ? latest_.reflection_texture
                                               : 0};
  latest_match_ = {in.match, in.match_threshold};
  latest_rate_ = in.cache_rate;
}

}  // namespace sideray::bridge
