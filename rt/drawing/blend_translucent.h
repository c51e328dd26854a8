// Blends translucent surfaces and sprites over a lit picture, shaded as gl/passes/translucency_pass.cpp draws their fragments:
// with the prefiltered environment and no reflection ray, and with a ray to each light in place of its shadow map. The order is
// that along each pixel's ray. Pixels: row 0 is the bottom row. One call at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/counters.h"
#include "rt/drawing/opaque_pixels.h"

namespace sideray::rt {

struct BlendRequest {
  TraceView view;
  const OpaquePixels* pixels = nullptr;
  std::span<const uint8_t> places;  // as rt/drawing/translucent_places.h has them
  bool aside = true;    // surfaces that bend or blur light show the picture aside (rt/drawing/seen_aside.h)
  bool shadows = true;  // rays say what hides lights
};

// Returns the rays that were traced.
Counters blend_translucent(const BlendRequest& request, TracedScene& scene, std::vector<glm::vec4>& picture);

}  // namespace sideray::rt
