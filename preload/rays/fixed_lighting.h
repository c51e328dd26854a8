// The lighting of the fixed function for one point that a ray hits, by Sideray's own formulas of it.
// sideray_scene_set_fixed_function has one set of lights a scene; a program may change them from draw to draw.
#pragma once

#include <sideray/tracer.h>

#include "preload/capture/draw_state.h"

namespace sideray::run {

// Writes the colour, 0..1, of a point in eye space, whose texture modulates. Both sides are lit: a mirror shows sides that the
// eye never sees.
void light_point(const Lighting& lighting, const DrawMaterial& material, const sideray_shading_point& point, float color[3]);

}  // namespace sideray::run
