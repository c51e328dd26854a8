#include "bridge/plan/frame_plan.h"

#include <algorithm>

#include "bridge/base/opaque_rays.h"
#include "bridge/base/reuse.h"
#include "bridge/base/whole_pixels.h"
#include "elementary/functions.h"
#include "model/material.h"
#include "rt/refraction/refraction.h"
#include "rt/light/veils.h"

namespace sideray::bridge {
namespace {

constexpr size_t most_masks = 32;
// Twice as many rays bring pictures no nearer to path tracers (docs/others.md), since filters use the neighbours' rays.
constexpr uint32_t ao_rays_a_pixel = 2;

// Holds what the plans of a frame's parts share.
struct Method {
  bool exact;      // translucent surfaces are shaded as in a reference
  bool raytraced;  // translucent surfaces are composited along rays
  bool hybrid;
  bool resolves;   // FramePlan::resolves
};

// Without rasterization, hybrid means that rays composite all surfaces of a pixel with the lighting of layers.
Method method_of(const sideray_translucency_options& o, Drawing drawing) {
  const bool exact = o.method == SIDERAY_TRANSLUCENCY_REFERENCE;
  const bool hybrid = o.method == SIDERAY_TRANSLUCENCY_HYBRID && o.layers > 0;
  const bool resolves = hybrid && drawing == Drawing::rays;
  return {exact, exact || resolves || o.method == SIDERAY_TRANSLUCENCY_RAYTRACED, hybrid && !resolves, resolves};
}

rt::FoliageOptions as_drawn() {
  return {.poses = SIDERAY_POSES_ALL, .cull_angle_deg = 0.0f, .eye = {}, .cull = {}};
}

rt::FoliageOptions plan_foliage(const RenderOptions& o, const Method& method) {
  if (method.exact) return as_drawn();
  return {.poses = o.poses.poses,
          .cull_angle_deg = o.poses.cull_angle_deg,
          .eye = {},
          .cull = {.keeps_translucent = method.raytraced, .remembers = o.picture.continues != 0}};
}

// Returns why no pixel can be whole although layers are cached; null: pixels can be.
const char* why_not_whole(const model::Snapshot& snapshot, const sideray_translucency_options& o) {
  if (!o.whole_pixels) return "whole pixels are off";
  return no_whole_pixels(o, snapshot.shader.shade != nullptr).reason;
}

// Returns the options for finding, matching and caching surfaces.
sideray_layer_inputs layer_inputs(const RenderOptions& options) {
  const sideray_translucency_options& o = options.translucency;
  sideray_layer_inputs layers = sideray_layer_inputs_defaults();
  layers.max_layers = o.layers;
  layers.step = o.step;
  layers.match = o.match;
  layers.match_threshold = o.match_threshold;
  layers.cache_rate = o.cache_rate;
  layers.denoise = options.picture.denoise;
  layers.bounces = o.bounces;
  return layers;
}

void plan_translucency(const model::Snapshot& snapshot, const RenderOptions& options, const Method& method,
                       FramePlan& plan) {
  const sideray_translucency_options& o = options.translucency;
  sideray_layer_inputs& layers = plan.layers;
  const bool sprites = has_sprites(snapshot);
  layers = layer_inputs(options);
  layers.mode = method.raytraced ? SIDERAY_COMPOSITE : SIDERAY_CACHE;
  layers.particles = (method.exact || method.resolves || (method.raytraced && o.particles)) && sprites;
  plan.resolves = method.resolves;
  plan.traced = method.raytraced ? gl::TracedSet::all_translucent : gl::TracedSet::visible_in_layers;
  plan.drops_particles = method.raytraced && !layers.particles && sprites;
  plan.traces = ((method.raytraced || method.hybrid) && has_traced(snapshot, plan.traced)) || layers.particles;
  if (!plan.traces) plan.traced = gl::TracedSet::none;
  layers.all_translucent = plan.traced == gl::TracedSet::all_translucent;
  // Without rasterization no mask is needed: the rays that would find the pixels to trace are those that trace them.
  plan.draws_mask = plan.traces && !method.exact && o.mask != SIDERAY_NO_MASK && !plan.draws_by_rays();
  // The count does not include sprites, so with them the mask only says where rays start.
  plan.mask_kind = o.mask == SIDERAY_COUNT_MASK && !layers.particles ? gl::MaskKind::count : gl::MaskKind::stencil;
  plan.rasters_translucency = !method.raytraced && o.method != SIDERAY_TRANSLUCENCY_OFF &&
                              (has_traced(snapshot, gl::TracedSet::all_translucent) || sprites);
  plan.distorts = o.method != SIDERAY_TRANSLUCENCY_OFF && has_distortion(snapshot);
  plan.checks = o.check && method.hybrid && plan.traces;
  plan.second_wave = method.hybrid && plan.traces && o.second_wave != 0 && o.cache_rate != SIDERAY_RATE_FULL;
  layers.refraction = o.refraction && rt::bends_light(snapshot) && (plan.traces || plan.rasters_translucency);
  if (method.exact || method.resolves) layers.max_layers = 0;
  // If layers are shown, as many are cached as requested.
  if (method.hybrid && plan.traces && !options.shows(SIDERAY_AOV_LAYERS))
    layers.max_layers = static_cast<uint32_t>(std::max<uint64_t>(most_surfaces(snapshot, plan.traced, o.layers), 1));
  if (method.exact && plan.traces) layers.light_samples = o.light_samples;
  if (plan.fills_cache()) plan.why_not_whole = why_not_whole(snapshot, o);
  layers.whole_pixels = plan.fills_cache() && !plan.why_not_whole;
  if (layers.whole_pixels) layers.others_bits = gl::others_stencil_bit;
}

// Plans a separate cache for layers that are shown, since rays that composite all surfaces leave none.
void plan_shown_layers(const model::Snapshot& snapshot, const RenderOptions& options, FramePlan& plan) {
  if (!plan.resolves || !options.shows(SIDERAY_AOV_LAYERS) || !has_traced(snapshot, gl::TracedSet::visible_in_layers)) return;
  plan.shown_layers = layer_inputs(options);
  plan.shown_layers.mode = SIDERAY_CACHE;
  plan.shown_layers.refraction = plan.layers.refraction;
  plan.shown_layers.ray_reuse = plan.layers.ray_reuse;
}

void plan_reuse(const model::Snapshot& snapshot, const RenderOptions& options, FramePlan& plan) {
  if (!plan.traces || plan.layers.light_samples > 0) return;
  const ReuseBound reuse = ray_reuse_of(snapshot, options);
  plan.layers.ray_reuse = reuse.radiance;
  plan.why_no_reuse = reuse.why_no_other;
}

// Returns the bits of lights with masks. A light without power needs none, unless its mask is shown.
uint32_t masked_lights(const model::Snapshot& snapshot, const RenderOptions& o) {
  const bool shown = o.shows(SIDERAY_AOV_SHADOW | SIDERAY_AOV_HIT_DISTANCE);
  uint32_t bits = 0;
  for (size_t i = 0; i < std::min(snapshot.lights.size(), most_masks); ++i)
    if (shown || is_lit(snapshot.lights[i])) bits |= 1u << i;
  return bits;
}

// Returns the radiance that a light must add to a white matt surface to get a shadow ray there: 1/512 of white as
// displayed; exposures below 0 do not raise it, since the picture may be stored and brightened later. With few lights
// this saves hardly any rays, and with more lights than masks each adds so little that errors sum up
// (docs/adr/0039-least-light.md).
float least_light_of(const model::Snapshot& snapshot, const RenderOptions& o) {
  constexpr ptrdiff_t few_lights = 8;
  const auto lit = std::count_if(snapshot.lights.begin(), snapshot.lights.end(), is_lit);
  if (lit <= few_lights || has_lit_light(snapshot, most_masks)) return 0.0f;
  return 0x1p-9f * elementary::exp2(-std::max(o.picture.exposure, 0.0f));
}

// Plans ambient occlusion, bounced light and reflection rays of opaque pixels.
void plan_opaque_rays(const model::Snapshot& snapshot, const RenderOptions& options, FramePlan& plan) {
  const int32_t ambient = options.picture.ambient;
  const bool chooses_reflections = options.picture.reflections == SIDERAY_REFLECTIONS_AUTO;
  OpaqueRays choice{};
  if (ambient == SIDERAY_AMBIENT_AUTO || ambient == SIDERAY_AMBIENT_BOUNCE || chooses_reflections) choice = opaque_rays_of(snapshot);
  if (ambient == SIDERAY_AMBIENT_AUTO) plan.why_no_bounce = choice.why_no_bounce;
  plan.bounces = ambient == SIDERAY_AMBIENT_BOUNCE || (ambient == SIDERAY_AMBIENT_AUTO && !plan.why_no_bounce);
  if (ambient == SIDERAY_AMBIENT_AUTO || plan.bounces) plan.why_no_ao = choice.why_no_ao;
  if (chooses_reflections) plan.why_no_reflections = choice.why_no_reflections;
  plan.masks.ao_rays = ambient != SIDERAY_AMBIENT_OFF && !plan.why_no_ao ? ao_rays_a_pixel : 0;
  plan.masks.ao_by_light = 1;
  plan.masks.unhidden_sky = plan.masks.ao_rays != 0 && rt::veils_sky(snapshot);
  plan.irradiance = sideray_irradiance_inputs_defaults();
  plan.irradiance.denoise = options.picture.denoise;
  plan.reflects = options.picture.reflections != 0 && !plan.why_no_reflections;
  plan.reflections = sideray_reflection_inputs_defaults();
  plan.reflections.max_roughness = model::most_mirrored_roughness;
  plan.reflections.denoise = options.picture.denoise;
}

// Plans which surfaces take the inexact shadow test, and which test it is.
void plan_inexact(const model::Snapshot& snapshot, const sideray_shadow_options& o, FramePlan& plan) {
  plan.marks_inexact =
      o.method == SIDERAY_SHADOWS_INEXACT && plan.masks_occlusion() && has_inexact(snapshot, o.inexact_target);
  if (!plan.marks_inexact) return;
  plan.masks.inexact = o.inexact;
  plan.masks.inexact_bias = o.inexact_bias;
  plan.masks.inexact_bits = gl::inexact_stencil_bit;
  plan.fills_rest = o.inexact == SIDERAY_INEXACT_RESTPOSE || o.inexact == SIDERAY_INEXACT_BOUNDED;
}

// Plans masks and shadow maps. Translucent surfaces that the rasterizer shades always use shadow maps.
void plan_occlusion(const model::Snapshot& snapshot, const RenderOptions& options, FramePlan& plan) {
  const sideray_shadow_options& o = options.shadows;
  const bool by_rays = options.traces_shadows();
  plan.masks = sideray_mask_inputs_defaults();
  plan.masks.denoise = options.picture.denoise;
  plan.masks.shadow_bias = o.bias;
  if (by_rays) plan.masks.shadow_lights = masked_lights(snapshot, options);
  if (by_rays) plan.masks.least_light = least_light_of(snapshot, options);
  plan.masks.combined_lights = by_rays && has_lit_light(snapshot, most_masks);
  plan_opaque_rays(snapshot, options, plan);
  // Rays that find the visible surfaces hit the same poses as shadow rays, so that no inexact test is needed.
  if (!plan.draws_by_rays()) plan_inexact(snapshot, o, plan);
  // Under a budget some pixels have no masks yet.
  const bool lacks_masks = by_rays && options.is_bounded();
  const bool on_opaque = (!by_rays || lacks_masks) && has_lit_light(snapshot);
  plan.shadow_maps =
      !plan.draws_by_rays() && plan.casts_shadows && (on_opaque || (plan.rasters_translucency && has_lit_light(snapshot)));
}

// Plans temporal averaging, which several positions do not need.
void plan_sequence(const RenderOptions& o, FramePlan& plan) {
  plan.averages = o.picture.taa && plan.samples == 1 && plan.layers.light_samples == 0;
  plan.motion = o.shows(SIDERAY_AOV_MOTION) ||
                (o.picture.continues && (plan.averages || (o.picture.denoise && plan.masks_occlusion())));
}

// Removes options that only the picture's colours need.
RenderOptions needed_without_color(RenderOptions o) {
  if (o.shows(SIDERAY_AOV_ANSWERS)) return o;
  if (!o.shows(SIDERAY_AOV_LAYERS | SIDERAY_AOV_MASK)) o.translucency.method = SIDERAY_TRANSLUCENCY_OFF;
  if (!o.shows(SIDERAY_AOV_SHADOW | SIDERAY_AOV_HIT_DISTANCE | SIDERAY_AOV_INEXACT)) o.shadows.method = SIDERAY_SHADOWS_OFF;
  o.picture.ambient = SIDERAY_AMBIENT_OFF;
  o.picture.reflections = o.picture.taa = 0;
  return o;
}

FramePlan plan_parts(const model::Snapshot& snapshot, const RenderOptions& o, Drawing drawing) {
  FramePlan plan{};
  plan.drawing = drawing;
  plan.ground_truth = o.shows(SIDERAY_AOV_FIRST | SIDERAY_AOV_GLASS | SIDERAY_AOV_BEHIND | SIDERAY_AOV_REFRACTION);
  plan.width = o.picture.width;
  plan.height = o.picture.height;
  plan.samples = o.picture.samples;
  plan.seed = o.picture.seed;
  plan.casts_shadows = o.shadows.method != SIDERAY_SHADOWS_OFF;
  plan.reference = o.is_reference;
  plan.glass_shadows =
      plan.casts_shadows && has_tints(snapshot) && (plan.reference || o.translucency.method != SIDERAY_TRANSLUCENCY_OFF);
  if (plan.reference) {
    plan.reflects = o.picture.reflections == 1;
    plan.layers.light_samples = o.reference.light_samples;
    plan.layers.bounces = o.reference.bounces;
    plan.caustics = o.reference.caustics != 0;
    plan.layers.refraction = o.reference.refraction;
    plan.foliage = as_drawn();
    return plan;
  }
  const Method method = method_of(o.translucency, drawing);
  plan_translucency(snapshot, o, method, plan);
  plan_reuse(snapshot, o, plan);
  plan_shown_layers(snapshot, o, plan);
  plan_occlusion(snapshot, o, plan);
  plan_sequence(o, plan);
  // Frames without rays need no poses, which cost an update. Without OpenGL, rays hit each plant in its drawn pose.
  plan.foliage = plan.uses_rays() && !plan.draws_by_rays() ? plan_foliage(o, method) : as_drawn();
  return plan;
}

}  // namespace

FramePlan plan_frame(const model::Snapshot& snapshot, const RenderOptions& options, Drawing drawing) {
  if (!options.picture.without_color) return plan_parts(snapshot, options, drawing);
  FramePlan plan = plan_parts(snapshot, needed_without_color(options), drawing);
  plan.without_color = true;
  return plan;
}

}  // namespace sideray::bridge
