// The part of the service that brings traced frames into textures. First everything that can fail, then the texels: a
// frame that fails leaves the last good outputs as they are.
#include "bridge/base/check_inputs.h"
#include "bridge/service/service.h"
#include "gl/resources/state_guard.h"

namespace sideray::bridge {
namespace {

// What a host's shader makes is in its space already.
LayerEncoding encoding_of(const gl::Functions& gl, const sideray_frame_inputs& in, bool shaded_by_host) {
  LayerEncoding encoding{.format = in.radiance_format, .float_ids = in.float_ids != 0 || !gl.integer_textures};
  if (!shaded_by_host) encoding.space = in.radiance_space, encoding.scale = in.radiance_scale;
  return encoding;
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
  ServiceView& view = *frame.view;
  const sideray_frame_inputs& in = frame.inputs;
  const gl::PixelTransferGuard transfer(gl_, policy_of(in));
  const gl::FramebufferGuard framebuffers(gl_, policy_of(in));
  const gl::ProgramGuard program(gl_, policy_of(in));
  const gl::TextureGuard textures(gl_, 0, 1, policy_of(in));
  gl_.ActiveTexture(GL_TEXTURE0);
  if (!in.layers_off && in.mode == SIDERAY_CACHE)
    view.cache_textures.prepare(gl_, view.cache, encoding_of(gl_, in, is_shaded_by_host(frame)));
  if (!in.layers_off && in.mode != SIDERAY_CACHE) view.composite_textures.prepare(gl_, view.composite);
  if (has_reflections(in)) view.reflection_texture.prepare(gl_, view.reflections);
  if (has_masks(in)) view.mask_textures.prepare(gl_, view.masks);
  if (filters_on_device(in)) view.mask_denoiser.prepare(gl_, denoiser_input(frame));
}

void Service::move_texels(Frame& frame) {
  ServiceView& view = *frame.view;
  const sideray_frame_inputs& in = frame.inputs;
  const bool persistent = transport_->persistent_upload;
  const gl::PixelTransferGuard transfer(gl_, policy_of(in));
  const gl::TextureGuard textures(gl_, 0, 1, policy_of(in));
  gl_.ActiveTexture(GL_TEXTURE0);
  uint64_t bytes = 0;
  if (!in.layers_off)
    bytes += in.mode == SIDERAY_CACHE ? view.cache_textures.upload(
                                            gl_, view.cache, encoding_of(gl_, in, is_shaded_by_host(frame)), persistent)
                                      : view.composite_textures.upload(gl_, view.composite, persistent);
  if (has_reflections(in)) bytes += view.reflection_texture.upload(gl_, view.reflections, persistent);
  if (has_masks(in)) bytes += view.mask_textures.upload(gl_, view.masks, persistent);
  frame.stats.bytes_upload = bytes;
}

uint64_t Service::bytes_cached(const Frame& frame) const {
  const ServiceView& view = *frame.view;
  const sideray_frame_inputs& in = frame.inputs;
  uint64_t bytes = 0;
  if (!in.layers_off) bytes += in.mode == SIDERAY_CACHE ? view.cache_textures.bytes() : view.composite_textures.bytes();
  if (has_reflections(in)) bytes += view.reflection_texture.bytes();
  if (has_masks(in)) bytes += view.mask_textures.bytes();
  return bytes;
}

void Service::publish(const Frame& frame) {
  ServiceView& view = *frame.view;
  const sideray_frame_inputs& in = frame.inputs;
  const bool masks = has_masks(in), reflections = has_reflections(in);
  const bool to_cache = !in.layers_off && in.mode == SIDERAY_CACHE, composite = !in.layers_off && !to_cache;
  const bool adds = in.adds_to != 0;  // masks stay those of the frame that it adds to
  view.latest = {.size = sizeof(view.latest),
                 .ticket = frame.ticket,
                 .mode = in.mode,
                 .view = in.view,
                 .x = in.x,
                 .y = in.y,
                 .width = in.width,
                 .height = in.height,
                 .layers = to_cache ? view.cache.layers : 0,
                 .radiance_texture = to_cache    ? view.cache_textures.radiance()
                                     : composite ? view.composite_textures.radiance()
                                                 : 0,
                 .distance_texture = to_cache    ? view.cache_textures.distance()
                                     : composite ? view.composite_textures.transmittance()
                                                 : 0,
                 .surface_id_texture = to_cache ? view.cache_textures.surface_id() : 0,
                 .shadow_texture = masks && in.shadow_lights ? view.mask_textures.shadow()
                                   : adds                    ? view.latest.shadow_texture
                                                             : 0,
                 .shadow_lights = adds ? view.latest.shadow_lights : in.shadow_lights,
                 .ao_texture = masks && in.ao_rays ? view.mask_textures.ambient()
                               : adds              ? view.latest.ao_texture
                                                   : 0,
                 .reflection_texture = reflections ? view.reflection_texture.id()
                                       : adds      ? view.latest.reflection_texture
                                                   : 0};
  view.latest_inputs = {in.match, in.match_threshold, in.cache_rate};
}

}  // namespace sideray::bridge
