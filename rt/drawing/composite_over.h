// Composites ray-traced translucent surfaces over a picture, as shaders/translucent/raster_composite.frag.glsl does.
// Row 0 of pixels is the bottom row.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "rt/base/executor.h"
#include "rt/composite/composite_image.h"

namespace sideray::rt {

void composite_over(const CompositeImage& image, Executor& executor, std::vector<glm::vec4>& picture);

}  // namespace sideray::rt
