#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "bridge/plan/plan_description.h"

namespace sideray::bridge {
namespace {

// Holds the facts that reasons mention.
struct Facts {
  const RenderOptions& options;
  const FramePlan& plan;
  size_t translucent;  // instances
  size_t lights, lit;
  bool sprites;
};

Facts facts_of(const model::Snapshot& snapshot, const RenderOptions& o, const FramePlan& plan) {
  const auto lit = std::count_if(snapshot.lights.begin(), snapshot.lights.end(), is_lit);
  return {o,   plan, count_translucent(snapshot), snapshot.lights.size(), static_cast<size_t>(lit),
          has_sprites(snapshot)};
}

std::string number_of(size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

template <typename Text>
std::string joined(const std::vector<Text>& parts) {
  return fmt::format("{}", fmt::join(parts, "; "));
}

bool is_exact(const Facts& f) {
  return f.plan.layers.light_samples > 0;
}

const char* rate_name(sideray_cache_rate rate) {
  constexpr const char* names[] = {"every masked pixel",
                                   "every second masked pixel, as on a chessboard",
                                   "every other row of masked pixels",
                                   "one of 2x2 masked pixels"};
  return names[rate];
}

// Returns why no translucent surface is traced.
std::string why_not_traced(const Facts& f) {
  const sideray_translucency_options& o = f.options.translucency;
  if (f.options.draws(SIDERAY_TRANSLUCENCY_OFF)) return "translucency is off";
  if (f.translucent == 0 && !f.sprites) return "nothing in the scene is translucent";
  if (f.options.draws(SIDERAY_TRANSLUCENCY_RASTER))
    return f.plan.draws_by_rays() ? "translucency has its raster look" : "translucency is rasterized";
  if (f.options.is_hybrid() && o.layers == 0) return "0 layers were asked for";
  if (f.translucent == 0) return "nothing but particles is translucent, and rays do not hit them";
  return fmt::format("none of {} is chosen for layers", number_of(f.translucent, "translucent object"));
}

// Says how far light is followed behind the visible surfaces.
std::string bounces_text(uint32_t bounces) {
  if (bounces == 1) return "one bounce";
  return bounces == 0 ? "paths of any number of bounces" : fmt::format("paths of {} bounces at most", bounces);
}

std::string why_traced(const Facts& f) {
  const FramePlan& p = f.plan;
  if (p.layers.mode == SIDERAY_COMPOSITE)
    return is_exact(f)
               ? fmt::format("all surfaces along each ray, to the last one, shaded as the reference does: {}",
                             bounces_text(p.layers.bounces))
               : fmt::format("{} along each ray", p.layers.max_layers == 0 ? "all surfaces" : number_of(p.layers.max_layers, "surface"));
  const sideray_translucency_options& o = f.options.translucency;
  std::string text = fmt::format("{} a pixel, {}", number_of(p.layers.max_layers, "layer"), rate_name(p.layers.cache_rate));
  if (p.layers.max_layers < o.layers) text += fmt::format("; {} asked for: no ray hits more", o.layers);
  if (p.mask_kind == gl::MaskKind::count && p.draws_mask) text += "; where the count is lower, so many";
  if (p.second_wave) text += "; then a second wave where no neighbour has an answer";
  return text;
}

std::string lights_traced(const Facts& f) {
  const auto masks = static_cast<size_t>(std::popcount(f.plan.masks.shadow_lights));
  std::string text = fmt::format("{} of opaque pixels, one a light", number_of(masks, "mask"));
  if (f.plan.masks.combined_lights) text += "; one more for all lights beyond the 32nd together";
  if (f.plan.masks.least_light > 0.0f)
    text += fmt::format("; where a light adds less than {} to white, no ray is traced", f.plan.masks.least_light);
  if (f.lit < f.lights)
    text += fmt::format("; {} without intensity cast{} none", number_of(f.lights - f.lit, "light"),
                        f.lights - f.lit == 1 ? "s" : "");
  return text;
}

std::string why_no_shadow_rays(const Facts& f) {
  if (!f.plan.casts_shadows) return "shadows are off";
  if (!f.options.traces_shadows())
    return f.plan.draws_by_rays() ? "a ray to each light, while pixels are lit, takes the place of its map"
                                  : "opaque pixels take shadow maps";
  return f.lights == 0 ? "the scene has no light" : "no light has intensity";
}

PlannedPass running(sideray_stage stage, std::string reason) {
  return {stage, true, std::move(reason)};
}

PlannedPass skipped(sideray_stage stage, std::string reason) {
  return {stage, false, std::move(reason)};
}

PlannedPass load_pass(const Facts&) {
  return running(SIDERAY_STAGE_LOAD, "the scene is read once");
}

PlannedPass build_pass(const Facts& f) {
  const bool runs = f.plan.reference || f.plan.uses_rays() || f.plan.ground_truth;
  return {SIDERAY_STAGE_BUILD, runs,
          runs ? "rays need what they hit, built with the first picture" : "no ray is traced"};
}

PlannedPass update_pass(const Facts& f) {
  const bool rays = f.plan.reference || f.plan.uses_rays();
  if (!rays) return skipped(SIDERAY_STAGE_UPDATE, "no ray is traced");
  const bool runs = f.options.picture.continues;
  return {SIDERAY_STAGE_UPDATE, runs,
          runs ? "what moved since the picture before" : "no picture comes before this one"};
}

PlannedPass gbuffer_pass(const Facts& f) {
  std::string reason =
      f.plan.draws_by_rays() ? "a ray finds the opaque surface of each pixel" : "opaque surfaces are rasterized";
  if (f.plan.motion) reason += "; so is their motion, for what is averaged over time";
  return running(SIDERAY_STAGE_GBUFFER, reason);
}

PlannedPass shadow_map_pass(const Facts& f) {
  if (f.plan.draws_by_rays()) return skipped(SIDERAY_STAGE_SHADOW_MAP, "without OpenGL rays take their place");
  const char* reason = "opaque pixels take them";
  if (f.plan.shadow_maps && f.options.traces_shadows())
    reason = f.options.is_bounded() ? "opaque pixels that have no masks yet take them" : "raster translucent surfaces take them";
  if (!f.plan.shadow_maps)
    reason = !f.plan.casts_shadows ? "shadows are off"
             : f.lit == 0                  ? "no light has intensity"
                                           : "opaque pixels take masks, and nothing else is rasterized";
  return {SIDERAY_STAGE_SHADOW_MAP, f.plan.shadow_maps, reason};
}

PlannedPass mask_pass(const Facts& f) {
  std::vector<std::string> runs;
  if (f.plan.draws_mask)
    runs.push_back(f.plan.mask_kind == gl::MaskKind::count ? "counts the traced surfaces of each pixel"
                                                           : "marks the pixels of traced surfaces");
  if (f.plan.layers.whole_pixels) runs.push_back("marks the pixels of others");
  if (f.plan.marks_inexact) runs.push_back("marks what takes the inexact shadow test");
  if (!runs.empty()) return running(SIDERAY_STAGE_MASK, joined(runs));
  if (!f.plan.traces) return skipped(SIDERAY_STAGE_MASK, why_not_traced(f));
  return skipped(SIDERAY_STAGE_MASK, is_exact(f) ? "the reference traces every pixel" : "every pixel is traced");
}

PlannedPass readback_pass(const Facts& f) {
  if (f.plan.draws_by_rays()) return skipped(SIDERAY_STAGE_READBACK, "everything is in memory");
  if (!f.plan.uses_rays()) return skipped(SIDERAY_STAGE_READBACK, "no ray is traced");
  std::string reason = "rays start at the depth that was drawn";
  if (f.plan.fills_rest) reason += ", shadow rays of plants where rays hit them";
  if (f.plan.reflects) reason += ", mirrored ones along its normals";
  return running(SIDERAY_STAGE_READBACK, reason);
}

PlannedPass trace_pass(const Facts& f) {
  std::vector<std::string> runs;
  if (f.plan.traces) runs.push_back(why_traced(f));
  if (f.plan.layers.refraction && f.plan.traces) runs.push_back("what is seen through surfaces that bend light is followed");
  if (f.plan.shown_layers.max_layers > 0)
    runs.push_back(fmt::format("{} a pixel are traced once more, to be shown", number_of(f.plan.shown_layers.max_layers, "layer")));
  if (f.plan.layers.ray_reuse > 0.0f)
    runs.push_back(fmt::format(
        "three of four pixels reuse the rays of their neighbours, and trace where these donors differ by more than {}",
        f.plan.layers.ray_reuse));
  if (f.plan.why_no_reuse) runs.push_back(f.plan.why_no_reuse);
  if (f.plan.bounces) runs.push_back("light that surfaces throw on each other, from one pixel of four");
  if (f.plan.reflects) runs.push_back("what smooth opaque surfaces mirror");
  const bool has_work = !runs.empty();
  if (!has_work) runs.push_back(why_not_traced(f));
  if (f.plan.why_no_bounce) runs.push_back(f.plan.why_no_bounce);
  if (f.plan.why_no_reflections) runs.push_back(f.plan.why_no_reflections);
  return {SIDERAY_STAGE_TRACE, has_work, joined(runs)};
}

PlannedPass trace_shadow_pass(const Facts& f) {
  const bool runs = f.plan.masks_shadows();
  return {SIDERAY_STAGE_TRACE_SHADOW, runs, runs ? lights_traced(f) : why_no_shadow_rays(f)};
}

PlannedPass trace_ao_pass(const Facts& f) {
  if (f.plan.masks.ao_rays != 0)
    return running(SIDERAY_STAGE_TRACE_AO, fmt::format("{} an opaque pixel", number_of(f.plan.masks.ao_rays, "ray")));
  return skipped(SIDERAY_STAGE_TRACE_AO, f.plan.why_no_ao ? f.plan.why_no_ao : "ambient occlusion is off");
}

PlannedPass denoise_pass(const Facts& f) {
  const bool layers = f.plan.traces && f.plan.layers.mode == SIDERAY_CACHE;
  const bool noisy = layers || f.plan.lights_by_rays();
  const bool runs = noisy && f.plan.masks.denoise;
  if (!noisy) return skipped(SIDERAY_STAGE_DENOISE, "nothing that is filtered is traced");
  if (!runs) return skipped(SIDERAY_STAGE_DENOISE, "denoising is off");
  std::vector<std::string> what;
  if (f.plan.masks_occlusion()) what.push_back("masks of lights with a size, of the sky, and of random tests");
  if (f.plan.bounces) what.push_back("light that bounces");
  if (layers || f.plan.reflects) what.push_back("what rough surfaces reflect");
  return running(SIDERAY_STAGE_DENOISE, joined(what));
}

PlannedPass upload_pass(const Facts& f) {
  if (f.plan.draws_by_rays()) return skipped(SIDERAY_STAGE_UPLOAD, "everything is in memory");
  const bool runs = f.plan.uses_rays();
  return {SIDERAY_STAGE_UPLOAD, runs, runs ? "what was traced goes back to the rasterizer" : "no ray is traced"};
}

PlannedPass light_pass(const Facts&) {
  return running(SIDERAY_STAGE_LIGHT, "opaque pixels are lit");
}

PlannedPass composite_pass(const Facts& f) {
  std::vector<const char*> runs;
  if (f.plan.rasters_translucency && f.plan.draws_by_rays())
    runs.push_back("translucent surfaces are blended in the order along each ray, with a ray to each light");
  else if (f.plan.rasters_translucency)
    runs.push_back(f.plan.traces ? "translucent surfaces are blended, the traced ones with their layers"
                                 : "translucent surfaces are blended");
  if (f.plan.layers.whole_pixels)
    runs.push_back("pixels whose surfaces are all among the layers are drawn at once, in the order along their rays");
  if (f.plan.why_not_whole) runs.push_back(f.plan.why_not_whole);
  if (f.plan.traces && f.plan.layers.mode == SIDERAY_COMPOSITE) runs.push_back("what rays composited is put over the picture");
  if (f.plan.distorts) runs.push_back("some surface distorts what is behind it");
  if (f.plan.averages) runs.push_back("the picture is averaged with those before");
  if (f.plan.drops_particles) runs.push_back("particles are left out: rays do not hit them");
  const bool has_work = f.plan.rasters_translucency || f.plan.traces || f.plan.distorts || f.plan.averages;
  if (runs.empty()) return skipped(SIDERAY_STAGE_COMPOSITE, why_not_traced(f));
  return {SIDERAY_STAGE_COMPOSITE, has_work, joined(runs)};
}

// Returns the passes of a reference, in which the rasterizer has no part.
std::vector<PlannedPass> reference_passes(const FramePlan& plan) {
  const PlannedPass none = skipped(SIDERAY_STAGE_LOAD, "the reference is drawn by rays alone");
  std::vector<PlannedPass> passes(SIDERAY_STAGE_TOTAL_FRAME, none);
  for (size_t stage = 0; stage < passes.size(); ++stage) passes[stage].stage = static_cast<sideray_stage>(stage);
  passes[SIDERAY_STAGE_LOAD] = running(SIDERAY_STAGE_LOAD, "the scene is read once");
  passes[SIDERAY_STAGE_BUILD] = running(SIDERAY_STAGE_BUILD, "rays need what they hit, every instance as it is drawn");
  passes[SIDERAY_STAGE_TRACE] =
      running(SIDERAY_STAGE_TRACE, "everything, exact and unlimited: " + bounces_text(plan.layers.bounces) +
                                       (plan.caustics ? ", with caustics" : ""));
  return passes;
}

}  // namespace

std::vector<PlannedPass> planned_passes(const model::Snapshot& snapshot, const RenderOptions& options,
                                        const FramePlan& plan) {
  if (plan.reference) return reference_passes(plan);
  const Facts f = facts_of(snapshot, options, plan);
  return {load_pass(f),    build_pass(f),    update_pass(f), gbuffer_pass(f),      shadow_map_pass(f),
          mask_pass(f),    readback_pass(f), trace_pass(f),  trace_shadow_pass(f), trace_ao_pass(f),
          denoise_pass(f), upload_pass(f),   light_pass(f),  composite_pass(f)};
}

}  // namespace sideray::bridge
