// What pictures say of their own error where their light was sampled. Any thread.
#pragma once

#include <sideray/sideray.h>

#include <glm/glm.hpp>
#include <vector>

namespace sideray::bridge {

// relMSE (docs/cli.md) of the picture from one half of the light samples, color + half_difference, against that from
// the other half, color - half_difference.
double self_error(const std::vector<glm::vec4>& color, const std::vector<glm::vec3>& half_difference);

// Fills the reference part of the statistics.
void state_self_error(sideray_render_stats& stats, uint32_t light_samples, const std::vector<glm::vec4>& color,
                      const std::vector<glm::vec3>& half_difference);

}  // namespace sideray::bridge
