// Distorts a lit picture behind translucent surfaces in screen space, as gl/passes/distortion_pass.cpp does. Row 0 of
// pixels is the bottom row.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "rt/drawing/opaque_pixels.h"

namespace sideray::rt {

void distort_picture(const OpaqueRequest& request, const OpaquePixels& pixels, TracedScene& scene,
                     std::vector<glm::vec4>& picture);

}  // namespace sideray::rt
