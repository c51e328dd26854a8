// Lights the opaque surfaces of a view's pixels: by the masks and reflections traced for them, else by shadow rays and
// the prefiltered environment, as shaders/light/raster_light.frag.glsl does. Other pixels show the sky. Row 0 of pixels
// is the bottom row. One call at a time.
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
  uint32_t shadow_lights = 0;             // lights that have masks; this and the next three are as in
                                          // sideray_mask_inputs
  bool combined_lights = false, sky = false, unhidden_sky = false;
  const IrradianceImage* bounced = nullptr;   // null: surfaces do not light each other
  const ReflectionImage* mirrored = nullptr;  // null: all surfaces reflect the prefiltered environment
  bool shadows = true;                        // rays shadow the lights that have no mask
};

// Refills `picture` with radiance; alpha is 1 where there is a surface, else 0.
Counters light_opaque_pixels(const OpaqueLightRequest& request, TracedScene& scene, std::vector<glm::vec4>& picture);

}  // namespace sideray::rt
