// What one frame does, decided once from the scene and the options: what nothing uses does not run. Any thread.
#pragma once

#include <sideray/sideray.h>

#include "gl/passes/pass_inputs.h"
#include "model/snapshot.h"
#include "rt/poses/foliage.h"

namespace sideray::bridge {

struct FramePlan {
  bool reference;  // everything by rays; of the rest, only light_samples counts
  bool traces, masks, shadow_maps, distorts, rasters_translucency;
  bool particles;        // rays meet sprites
  bool drops_particles;  // neither rays nor the rasterizer show them
  gl::TracedSet traced;
  gl::MaskKind mask_kind;
  bool second_wave;
  sideray_service_mode mode;
  uint32_t layers;         // no more than a ray can meet, where the mode is SIDERAY_CACHE
  uint32_t light_samples;  // 0: nothing of the picture is a reference
  uint32_t shadow_lights;  // whose shadows on opaque pixels are traced: bit i = light i, which sends some light
  uint32_t ao_rays;        // a pixel; 0 = no ambient occlusion
  rt::FoliageOptions foliage;
  bool averages;       // with the pictures before: temporal anti-aliasing
  bool motion;         // how what is seen moved is wanted
  bool reflections;    // of opaque surfaces, by rays
  bool marks_inexact;  // some surface takes the inexact shadow test
  bool fills_rest;     // and needs to know where rays meet it
  bool masks_occlusion() const { return shadow_lights != 0 || ao_rays != 0; }
  bool lights_by_rays() const { return masks_occlusion() || reflections; }  // the opaque picture waits for them
  bool uses_rays() const { return traces || lights_by_rays(); }
};

// Throws Failure (INVALID_ARGUMENT, UNSUPPORTED) and names the option.
void check_options(const sideray_render_options& options);
FramePlan plan_frame(const model::Snapshot& snapshot, const sideray_render_options& options);

// How many traced surfaces a ray through the scene meets, at most; `enough` where it may be as many or more.
uint64_t most_surfaces(const model::Snapshot& snapshot, gl::TracedSet traced, uint64_t enough);
bool has_sprites(const model::Snapshot& snapshot);
inline bool is_lit(const model::Light& light) {
  return light.intensity != glm::vec3(0);
}

// What the service is asked for; view, framebuffer and rectangle are the caller's to fill.
sideray_frame_inputs frame_inputs(const FramePlan& plan, const sideray_render_options& options);

}  // namespace sideray::bridge
