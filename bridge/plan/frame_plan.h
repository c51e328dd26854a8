// Decides what a frame does, once, from the scene and the options; work that nothing uses is left out. Any thread.
#pragma once

#include <sideray/sideray.h>

#include <bit>
#include <cstdint>

#include "bridge/base/render_options.h"
#include "bridge/plan/scene_facts.h"
#include "gl/passes/pass_inputs.h"
#include "gl/scene/shadow_plan.h"
#include "model/snapshot.h"
#include "rt/poses/foliage.h"

namespace sideray::bridge {

// Says what draws the frame: OpenGL with rays beside it, or rays alone.
enum class Drawing { raster, rays };

// Static texts say why something is left out; null where it runs, or was not requested.
struct FramePlan {
  Drawing drawing;
  bool resolves;   // composited layers of surfaces that bend light are resolved, and rough reflections are filtered
  bool reference;  // rays draw everything; of `layers`, light_samples, bounces and refraction apply
  bool traces, draws_mask, shadow_maps, distorts;
  bool rasters_translucency;  // fragments are blended, or surfaces along rays in the same way
  bool drops_particles;  // neither rays nor the rasterizer show sprites
  gl::TracedSet traced;
  gl::MaskKind mask_kind;
  bool second_wave;
  bool checks;           // layers are compared with all surfaces along the rays
  bool caustics;         // caustics of lamps on the paths of a reference
  bool casts_shadows;    // lights cast shadows
  bool glass_shadows;    // drawn translucent surfaces tint the light; others cast no shadow
  uint32_t width, height, samples, seed;
  bool bounces;   // opaque surfaces reflect light onto others
  bool reflects;  // opaque surfaces have reflections by rays
  // The renderer passes these to the service as any host does, with the names of textures. The rasterizer uses
  // `refraction` even where nothing is traced.
  sideray_layer_inputs layers;            // with `traces`
  // The cache that `--aov layers` shows where rays composite all surfaces. max_layers 0: none.
  sideray_layer_inputs shown_layers;
  sideray_mask_inputs masks;              // with masks_occlusion()
  sideray_irradiance_inputs irradiance;   // with `bounces`
  sideray_reflection_inputs reflections;  // with `reflects`
  const char *why_not_whole, *why_no_reuse, *why_no_ao, *why_no_bounce, *why_no_reflections;
  rt::FoliageOptions foliage;
  bool averages;       // with the pictures before: temporal anti-aliasing
  bool motion;         // motion vectors are needed
  bool marks_inexact;  // some surface takes the inexact shadow test
  bool fills_rest;     // the G-buffer also stores where rays hit such a surface
  bool without_color;  // nothing is lit or averaged
  bool ground_truth;   // its channels are shown, by separate rays
  bool masks_shadows() const { return masks.shadow_lights != 0 || masks.combined_lights; }
  // Masks hold the tints of opaque surfaces. Beside them, maps tint only the light on translucent surfaces, and the maps
  // of many lamps cost more than that shows.
  gl::TintedLights tint_maps() const {
    if (!glass_shadows) return gl::TintedLights::none;
    return masks_shadows() ? gl::TintedLights::directional : gl::TintedLights::all;
  }
  bool masks_occlusion() const { return masks_shadows() || masks.ao_rays != 0; }
  uint32_t shadow_masks() const {
    return static_cast<uint32_t>(std::popcount(masks.shadow_lights)) + (masks.combined_lights ? 1u : 0u);
  }
  uint32_t sky_masks() const { return (masks.ao_rays != 0 ? 1u : 0u) + (masks.unhidden_sky ? 1u : 0u); }
  bool lights_by_rays() const { return masks_occlusion() || bounces || reflects; }  // the opaque picture waits for them
  bool draws_by_rays() const { return drawing == Drawing::rays; }
  bool uses_rays() const { return draws_by_rays() || traces || lights_by_rays(); }
  bool fills_cache() const { return traces && layers.mode == SIDERAY_CACHE; }
  uint32_t layers_to_show() const { return fills_cache() ? layers.max_layers : shown_layers.max_layers; }
  bool composites() const { return traces && layers.mode == SIDERAY_COMPOSITE; }
};

FramePlan plan_frame(const model::Snapshot& snapshot, const RenderOptions& options, Drawing drawing = Drawing::raster);

}  // namespace sideray::bridge
