// Draws lines and points over the rays' hits, as OpenGL rasterizes them: a pixel wide, by the diamond-exit rule. One
// call at a time.
#pragma once

#include "rt/drawing/opaque_pixels.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Changes the pixels where a line or point is nearer; of several at the same depth the first one stays.
void draw_thin(const OpaqueRequest& request, const ShadingScene& scene, OpaquePixels& pixels);

}  // namespace sideray::rt
