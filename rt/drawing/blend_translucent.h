// Blends translucent surfaces and sprites over a lit picture, shaded as gl/passes/translucency_pass.cpp draws their
// fragments: with the prefiltered environment, without reflection rays, and with a ray to each light instead of its
// shadow map. They are blended in the order along each pixel's ray. Row 0 of pixels is the bottom row. One call at a
// time.
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
  std::span<const uint8_t> places;  // from rt/drawing/translucent_places.h
  bool aside = true;    // surfaces that bend or blur light show the refracted picture (rt/drawing/seen_aside.h)
  bool shadows = true;  // rays shadow the lights
};

// Returns the counts of traced rays.
Counters blend_translucent(const BlendRequest& request, TracedScene& scene, std::vector<glm::vec4>& picture);

}  // namespace sideray::rt
