// Draws lines and points over what rays have found, as OpenGL rasterizes them: a pixel wide, by the diamond-exit rule.
// One call at a time.
#pragma once

#include "rt/drawing/opaque_pixels.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Changes the pixels of which some line or point is nearer; of those equally near the first one counts.
void draw_thin(const OpaqueRequest& request, const ShadingScene& scene, OpaquePixels& pixels);

}  // namespace sideray::rt
