// What one frame does, decided once from the scene and the options: what nothing uses does not run. Any thread.
#pragma once

#include <sideray/renderer.h>

#include <bit>
#include <cstdint>

#include "bridge/plan/render_options.h"
#include "bridge/plan/scene_facts.h"
#include "gl/passes/pass_inputs.h"
#include "model/snapshot.h"
#include "rt/poses/foliage.h"

namespace sideray::bridge {

struct FramePlan {
  bool reference;  // everything is drawn by rays; of the rest, only light_samples, bounces and foliage count
  bool traces, masks, shadow_maps, distorts, rasters_translucency;
  bool particles;        // rays hit sprites
  bool drops_particles;  // neither rays nor the rasterizer show them
  gl::TracedSet traced;
  gl::MaskKind mask_kind;
  bool second_wave;
  sideray_service_mode mode;
  bool refracts;           // rays are bent by solids
  uint32_t layers;         // no more than a ray can hit, where the mode is SIDERAY_CACHE
  bool whole_pixels;       // are drawn at once, and fragments of translucent surfaces left out there
  const char* why_not_whole;  // static text; null with whole_pixels, or where no cache is filled
  float ray_reuse;             // most radiance by which donors may differ; 0: every layer traces its own rays
  const char* why_no_reuse;    // static text; null but where it was left to the plan and none is supported
  float shading_reuse;         // radiance by which layers may change that keep their light; 0: every one is shaded
  const char* why_no_shading_reuse;  // static text; null but where it was left to the plan and none is supported
  uint32_t light_samples;  // 0: nothing of the picture is a reference
  uint32_t bounces;        // of light in a reference; 0 = unlimited
  uint32_t shadow_lights;  // whose shadows on opaque pixels are traced: bit i = light i, which sends some light
  float least_light;       // radiance of a white surface under which a light needs no shadow ray; 0: each has its own
  bool combined_lights;    // a mask that all lights beyond those share: the public interface's 33rd and on
  uint32_t ao_rays;        // a pixel; 0 = no ambient occlusion
  const char* why_no_ao;           // static text; null with ao_rays, or where it is off
  bool unhidden_sky;       // a mask of what nothing opaque hides, since translucent surfaces keep some of the sky's light
  rt::FoliageOptions foliage;
  bool averages;       // with the pictures before: temporal anti-aliasing
  bool motion;         // how what is seen moved is needed
  bool reflections;    // of opaque surfaces, by rays
  const char* why_no_reflections;  // static text; null with them, or where they are off
  bool marks_inexact;  // some surface takes the inexact shadow test
  bool fills_rest;     // and needs to know where rays hit it
  bool ground_truth;   // channels of it are shown, by rays of their own beside the frame's
  bool masks_shadows() const { return shadow_lights != 0 || combined_lights; }
  bool masks_occlusion() const { return masks_shadows() || ao_rays != 0; }
  uint32_t shadow_masks() const { return static_cast<uint32_t>(std::popcount(shadow_lights)) + combined_lights; }
  uint32_t sky_masks() const { return (ao_rays != 0 ? 1u : 0u) + unhidden_sky; }
  bool lights_by_rays() const { return masks_occlusion() || reflections; }  // the opaque picture waits for them
  bool uses_rays() const { return traces || lights_by_rays(); }
  bool fills_cache() const { return traces && mode == SIDERAY_CACHE; }
  bool composites() const { return traces && mode == SIDERAY_COMPOSITE; }
};

FramePlan plan_frame(const model::Snapshot& snapshot, const RenderOptions& options);

}  // namespace sideray::bridge
