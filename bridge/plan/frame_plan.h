// What one frame does, decided once from the scene and the options: what nothing uses does not run. Any thread.
#pragma once

#include <sideray/sideray.h>

#include <bit>
#include <cstdint>

#include "bridge/base/render_options.h"
#include "bridge/plan/scene_facts.h"
#include "gl/passes/pass_inputs.h"
#include "model/snapshot.h"
#include "rt/poses/foliage.h"

namespace sideray::bridge {

// What draws the frame: OpenGL with rays beside it, or rays alone.
enum class Drawing { raster, rays };

// Static texts say why something is left out; null where it runs, or was not asked for.
struct FramePlan {
  Drawing drawing;
  bool resolves;   // of layers that are composited: what bends light is resolved and rough reflections are filtered
  bool reference;  // everything is drawn by rays: of `layers`, light_samples, bounces and refraction count
  bool traces, draws_mask, shadow_maps, distorts;
  bool rasters_translucency;  // fragments are blended, or what is seen along rays as they would be
  bool drops_particles;  // neither rays nor the rasterizer show them
  gl::TracedSet traced;
  gl::MaskKind mask_kind;
  bool second_wave;
  bool checks;           // layers are compared with all surfaces along the rays
  bool caustics;         // caustics of lamps on the paths of a reference
  bool casts_shadows;    // lights are hidden from what they do not reach
  bool glass_shadows;    // and what is translucent tints them: where none of it is drawn, none throws a shadow
  uint32_t width, height, samples, seed;
  bool bounces;   // light of opaque surfaces is traced on to others
  bool reflects;  // of opaque surfaces, by rays
  // The renderer asks the service for these, as any host does, and adds the names of textures. The rasterizer obeys
  // `refraction` also where nothing is traced.
  sideray_layer_inputs layers;            // with `traces`
  // The cache that `--aov layers` shows where the picture needs none: rays composite all surfaces. max_layers 0: none.
  sideray_layer_inputs shown_layers;
  sideray_mask_inputs masks;              // with masks_occlusion()
  sideray_irradiance_inputs irradiance;   // with `bounces`
  sideray_reflection_inputs reflections;  // with `reflects`
  const char *why_not_whole, *why_no_reuse, *why_no_ao, *why_no_bounce, *why_no_reflections;
  rt::FoliageOptions foliage;
  bool averages;       // with the pictures before: temporal anti-aliasing
  bool motion;         // how what is seen moved is needed
  bool marks_inexact;  // some surface takes the inexact shadow test
  bool fills_rest;     // the G-buffer also stores where rays hit that surface
  bool without_color;  // nothing is lit, and the average is left out
  bool ground_truth;   // channels of it are shown, by rays of their own beside the frame's
  bool masks_shadows() const { return masks.shadow_lights != 0 || masks.combined_lights; }
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
