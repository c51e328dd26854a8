#include "bridge/drawing/trace_inputs.h"

#include "bridge/drawing/views.h"

namespace sideray::bridge {
namespace {

sideray_mask_source mask_source(const FramePlan& plan) {
  if (!plan.draws_mask) return SIDERAY_MASK_NONE;
  return plan.mask_kind == gl::MaskKind::count ? SIDERAY_MASK_COUNT : SIDERAY_MASK_STENCIL;
}

sideray_frame_source source_of(const PictureJob& job) {
  sideray_frame_source source = sideray_frame_defaults().source;
  source.width = static_cast<int32_t>(job.plan.width);
  source.height = static_cast<int32_t>(job.plan.height);
  source.mask = mask_source(job.plan);
  source.stencil_bits = gl::mask_stencil_bits;
  return source;
}

}  // namespace

FrameInputs trace_inputs(const PictureJob& job, const FramePosition& position) {
  const FramePlan& plan = job.plan;
  const RenderOptions& o = job.options;
  FrameInputs inputs;
  inputs.view = world_view(position.view, job.snapshot->origin);
  inputs.source = source_of(job);
  if (plan.traces) inputs.layers = plan.layers;
  if (plan.masks_occlusion()) inputs.masks = plan.masks;
  if (plan.bounces) inputs.irradiance = plan.irradiance;
  if (plan.reflects) inputs.reflections = plan.reflections;
  inputs.shadows = plan.casts_shadows;
  inputs.continues = o.picture.continues && job.sequence.follows();
  inputs.seed = position.seed;
  inputs.deadline_ms = o.picture.deadline_ms;
  inputs.budget_ms = o.picture.budget_ms;
  inputs.budget_pieces = o.diagnostics.budget_pieces;
  inputs.exact_points = o.diagnostics.exact_points;
  inputs.inspection.wanted = job.sequence.wanted(plan);
  inputs.inspection.wanted_light = job.sequence.wanted_light(plan);
  inputs.inspection.position = position.number;
  inputs.inspection.position_frames = job.sequence.position_frames();
  inputs.inspection.hit_distances = o.shows(SIDERAY_AOV_HIT_DISTANCE);
  return inputs;
}

}  // namespace sideray::bridge
