// Draws whole pictures by rays, exact and unlimited, and says how large the error of sampled light is. GL thread.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "bridge/renderer/picture_job.h"

namespace sideray::bridge {

// Times it as it is drawn, without a warm-up: it takes long enough, and nothing of it is kept from frame to frame.
void draw_reference(const PictureJob& job, Picture& picture);

// Fills the reference part of the statistics. `half_difference`: of the two halves of the light samples, one gave the
// picture `color` + half_difference, the other `color` - half_difference.
void state_self_error(uint32_t light_samples, const std::vector<glm::vec4>& color,
                      const std::vector<glm::vec3>& half_difference, sideray_render_stats& stats);

}  // namespace sideray::bridge
