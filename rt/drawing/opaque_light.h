// Lights the opaque surfaces that a view's pixels show: by the masks and reflections that were traced for them, else by shadow
// rays and the prefiltered environment, as shaders/light/raster_light.frag.glsl does. What shows no surface shows the sky.
// Pixels: row 0 is the bottom row. One call at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/counters.h"
#include "rt/drawing/opaque_pixels.h"
#include "rt/irradiance/irradiance_request.h"
#include "rt/masks/mask_request.h"
#include "rt/reflections/reflection_request.h"

namespace sideray::rt {

struct OpaqueLightRequest {
  TraceView view;
  const OpaquePixels* pixels = nullptr;
  const OcclusionMasks* masks = nullptr;  // null: none were traced
  uint32_t shadow_lights = 0;             // of the masks, as sideray_mask_inputs has them, like the next three
  bool combined_lights = false, sky = false, unhidden_sky = false;
  const IrradianceImage* bounced = nullptr;   // null: no surface lights another one
  const ReflectionImage* mirrored = nullptr;  // null: everything mirrors the prefiltered environment
  bool shadows = true;                        // rays say what hides lights that have no mask
};

// Refills `picture`: radiance, and 1 where a surface is seen, else 0.
Counters light_opaque_pixels(const OpaqueLightRequest& request, TracedScene& scene, std::vector<glm::vec4>& picture);

}  // namespace sideray::rt
