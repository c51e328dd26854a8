#include "bridge/renderer/trace_inputs.h"

#include "bridge/renderer/views.h"
#include "model/material.h"

namespace sideray::bridge {
namespace {

sideray_mask_source mask_source(const FramePlan& plan) {
  if (!plan.masks) return SIDERAY_MASK_NONE;
  return plan.mask_kind == gl::MaskKind::count ? SIDERAY_MASK_COUNT : SIDERAY_MASK_STENCIL;
}

sideray_layer_inputs layer_inputs(const FramePlan& plan, const RenderOptions& options) {
  const sideray_translucency_options& o = options.translucency;
  sideray_layer_inputs layers = sideray_layer_inputs_defaults();
  layers.mode = plan.mode;
  layers.max_layers = plan.layers;
  layers.all_translucent = plan.traced == gl::TracedSet::all_translucent;
  layers.step = o.step;
  layers.match = o.match;
  layers.match_threshold = o.match_threshold;
  layers.cache_rate = o.cache_rate;
  layers.denoise = options.denoise;
  layers.ray_reuse = plan.ray_reuse;
  layers.shading_reuse = plan.shading_reuse;
  layers.refraction = plan.refracts;
  layers.particles = plan.particles;
  layers.whole_pixels = plan.whole_pixels;
  layers.light_samples = plan.light_samples;
  layers.bounces = plan.bounces;
  layers.others_bits = plan.whole_pixels ? gl::others_stencil_bit : 0;
  return layers;
}

sideray_mask_inputs mask_inputs(const FramePlan& plan, const RenderOptions& options) {
  const sideray_shadow_options& o = options.shadows;
  sideray_mask_inputs masks = sideray_mask_inputs_defaults();
  masks.shadow_lights = plan.shadow_lights;
  masks.combined_lights = plan.combined_lights;
  masks.shadow_bias = o.bias;
  masks.least_light = plan.least_light;
  masks.ao_rays = plan.ao_rays;
  masks.ao_by_light = 1;
  masks.unhidden_sky = plan.unhidden_sky;
  masks.denoise = options.denoise;
  if (!plan.marks_inexact) return masks;
  masks.inexact = o.inexact;
  masks.inexact_bias = o.inexact_bias;
  masks.inexact_bits = gl::inexact_stencil_bit;
  return masks;
}

sideray_reflection_inputs reflection_inputs(const RenderOptions& options) {
  sideray_reflection_inputs reflections = sideray_reflection_inputs_defaults();
  reflections.max_roughness = model::most_mirrored_roughness;
  reflections.denoise = options.denoise;
  return reflections;
}

sideray_frame_source source_of(const PictureJob& job) {
  sideray_frame_source source = sideray_frame_defaults().source;
  source.framebuffer = job.rasterizer.framebuffer();
  source.width = static_cast<int32_t>(job.options.width);
  source.height = static_cast<int32_t>(job.options.height);
  source.mask = mask_source(job.plan);
  source.stencil_bits = gl::mask_stencil_bits;
  if (job.plan.motion) source.motion_texture = job.rasterizer.motion_texture();
  return source;
}

}  // namespace

FrameInputs trace_inputs(const PictureJob& job, const FramePosition& position) {
  const FramePlan& plan = job.plan;
  const RenderOptions& o = job.options;
  FrameInputs inputs;
  inputs.view = world_view(position.view, job.snapshot->origin);
  inputs.source = source_of(job);
  if (plan.traces) inputs.layers = layer_inputs(plan, o);
  if (plan.masks_occlusion()) inputs.masks = mask_inputs(plan, o);
  if (plan.fills_rest) inputs.masks->rest_texture = job.rasterizer.rest_texture();
  if (plan.reflections) inputs.reflections = reflection_inputs(o);
  if (plan.reflections) inputs.reflections->normal_texture = job.rasterizer.normal_texture();
  inputs.shadows = o.shadows.method != SIDERAY_SHADOWS_OFF;
  inputs.continues = o.continues;
  inputs.seed = position.seed;
  inputs.deadline_ms = o.deadline_ms;
  inputs.exact_points = o.exact_points;
  inputs.inspection.hit_distances = o.shows(SIDERAY_AOV_HIT_DISTANCE);
  return inputs;
}

}  // namespace sideray::bridge
