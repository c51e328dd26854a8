// Computes the fixed function's lighting at a hit, by Sideray's own formulas. sideray_scene_set_fixed_function() is not
// enough: it has one set of lights per scene, but a program may change its lights from draw to draw.
#pragma once

#include <sideray/tracer.h>

#include "preload/capture/draw_state.h"

namespace sideray::run {

// Writes the colour, 0..1, of a point in eye space with a texture that modulates. Lights both sides, because mirrors
// show sides that the eye never sees.
void light_point(const Lighting& lighting, const DrawMaterial& material, const sideray_shading_point& point, float color[3]);

}  // namespace sideray::run
