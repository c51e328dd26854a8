// Defines where pictures are seen from: cameras, positions within the pixel, and views as hosts state them. Any thread.
#pragma once

#include <sideray/renderer.h>

#include <glm/glm.hpp>

#include "gl/scene/raster_view.h"

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) that names the fault.
void check_camera(const sideray_camera& camera);

// Returns the offset from the pixel centre of sample i of n, in pixels. A single sample is at the centre.
glm::vec2 sample_jitter(uint32_t i, uint32_t samples);

// Returns the rasterizer's camera as a host would state it: in world space.
sideray_view world_view(const gl::RasterView& view, glm::dvec3 origin);

}  // namespace sideray::bridge
