// The part of Renderer that traces what a reduced rate left without an answer. As any host could: docs/embedding.md.
#include "bridge/renderer/renderer.h"

namespace sideray::bridge {
namespace {

// A frame's statistics with those of its second wave. The pixels of that wave are masked ones already counted.
void add_second_wave(rt::Counters& sum, const rt::Counters& wave) {
  sum.readback_ms += wave.readback_ms, sum.trace_ms += wave.trace_ms, sum.upload_ms += wave.upload_ms;
  sum.rays_primary += wave.rays_primary, sum.rays_reflection += wave.rays_reflection;
  sum.rays_shadow += wave.rays_shadow;
  sum.rays_skipped += wave.rays_skipped, sum.layers_skipped += wave.layers_skipped;
  sum.points_shaded += wave.points_shaded, sum.points_not_finite += wave.points_not_finite;
  sum.layers_found += wave.layers_found, sum.traversals_wasted += wave.traversals_wasted;
  sum.bytes_readback += wave.bytes_readback, sum.bytes_upload += wave.bytes_upload;
}

}  // namespace

void Renderer::trace_second_wave(const FramePlan& plan, const gl::RasterView& view,
                                 const RenderOptions& options, sideray_ticket first, FrameTimer& timer,
                                 rt::Counters& sum) {
  bool asked = false;
  timer.stage(SIDERAY_STAGE_MASK, [&] { asked = rasterizer_->mask_asked(translucency(plan, options)); });
  if (!asked) return;
  FrameInputs inputs = trace_inputs(plan, view, options);
  inputs.layers->adds_to = first;
  inputs.layers->requested_bits = gl::asked_stencil_bit;
  inputs.offscreen.redraws = true;
  inputs.offscreen.timed = timer.staged();
  const sideray_ticket ticket = service_->submit(inputs);
  service_->wait(ticket, SIDERAY_JOB_ALL, -1);
  const rt::Counters wave = service_->stats(ticket);
  timer.add(SIDERAY_STAGE_READBACK, wave.readback_ms);
  timer.add(SIDERAY_STAGE_TRACE, wave.trace_ms);
  timer.add(SIDERAY_STAGE_UPLOAD, wave.upload_ms);
  add_second_wave(sum, wave);
}

}  // namespace sideray::bridge
