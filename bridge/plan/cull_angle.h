// Computes the angle below which rays skip an instance. Any thread.
#pragma once

#include <sideray/renderer.h>

namespace sideray::bridge {

// Returns the angle in degrees: the option's own, less in views narrower than 30 degrees, 0 in orthographic ones.
float cull_angle_deg(const sideray_camera& camera, float option_deg);

}  // namespace sideray::bridge
