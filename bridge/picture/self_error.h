// Estimates the error of a picture's sampled light. Any thread.
#pragma once

#include <sideray/renderer.h>

#include <glm/glm.hpp>
#include <vector>

namespace sideray::bridge {

// Fills the reference part of the statistics. `half_difference`: the two halves of the light samples gave the pictures
// `color` + half_difference and `color` - half_difference.
void state_self_error(uint32_t light_samples, uint32_t bounces, const std::vector<glm::vec4>& color,
                      const std::vector<glm::vec3>& half_difference, sideray_render_stats& stats);

}  // namespace sideray::bridge
