// The part of the service that masks opaque pixels: traced by its thread, filtered there or on the GL thread.
#include "bridge/base/check_inputs.h"
#include "bridge/base/local_view.h"
#include "bridge/service/service.h"
#include "gl/resources/state_guard.h"

namespace sideray::bridge {

std::vector<rt::OpaquePoint> Service::exact_points(const Frame& frame) {
  if (!exact_points_) return {};
  return tracer_->tracer.trace_points(local_view(frame.inputs.view, frame.snapshot->origin),
                                      static_cast<uint32_t>(frame.inputs.width),
                                      static_cast<uint32_t>(frame.inputs.height));
}

void Service::trace_masks(Frame& frame) {
  const sideray_frame_inputs& in = frame.inputs;
  const std::vector<rt::OpaquePoint> points = exact_points(frame);
  const rt::MaskRequest request{.view = local_view(in.view, frame.snapshot->origin),
                                .width = static_cast<uint32_t>(in.width),
                                .height = static_cast<uint32_t>(in.height),
                                .depth = frame.depth,
                                .subpixel = subpixel_,
                                .lights = in.shadow_lights,
                                .ao_rays = in.ao_rays,
                                .ao_distance = in.ao_distance,
                                .inexact = in.inexact,
                                .inexact_bias = in.inexact_bias,
                                .inexact_bits = in.inexact_bits,
                                .rest_offsets = frame.readback.rest_offsets(),
                                .points = points,
                                .hit_distances = hit_distances_,
                                .filters = in.denoise != 0 ? &frame.view->mask_filters : nullptr,
                                .filters_later = in.denoise_on == SIDERAY_DENOISE_GPU,
                                .sequence = frame.sequence,
                                .motion = frame.readback.motion(),
                                .seed = in.seed,
                                .cancelled = &frame.cancelled,
                                .deadline = frame.mask_deadline};
  const rt::TraceCounters counters = tracer_->tracer.trace_masks(request, frame.view->masks);
  if (frame.cancelled) frame.view->mask_filters = {};  // no frame follows this one
  frame.stats.trace_shadow_ms = counters.shadow_ms;
  frame.stats.trace_ao_ms = counters.ao_ms;
  frame.stats.denoise_ms = counters.denoise_ms;
  frame.stats.rays_shadow = counters.rays_shadow;
  frame.stats.rays_ao = counters.rays_ao;
  frame.stats.pixels_total = counters.pixels_total;
}

MaskDenoiser::Input Service::denoiser_input(const Frame& frame) const {
  const sideray_frame_inputs& in = frame.inputs;
  return {.filters = frame.view->mask_filters,
          .masks = frame.view->masks,
          .snapshot = *frame.snapshot,
          .lights = in.shadow_lights,
          .random = rt::is_random(in.inexact, in.inexact_bits),
          .motion = in.motion_texture,
          .sequence = frame.sequence};
}

void Service::denoise_masks(Frame& frame) {
  const Clock::time_point start = Clock::now();
  const gl::StatePolicy policy = policy_of(frame.inputs);
  {
    const gl::PixelTransferGuard transfer(gl_, policy);
    const gl::FramebufferGuard framebuffers(gl_, policy);
    const gl::DrawGuard draw(gl_, policy);
    const gl::TextureGuard textures(gl_, 0, 8, policy);
    frame.stats.bytes_upload += frame.view->mask_denoiser.denoise(gl_, denoiser_input(frame), frame.view->mask_textures,
                                                                  transport_->persistent_upload);
  }
  if (timed_) gl_.Finish();
  frame.stats.denoise_ms += std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace sideray::bridge
