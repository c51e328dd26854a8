#include "bridge/picture/self_error.h"

namespace sideray::bridge {
namespace {

// relMSE (docs/cli.md) of the picture from one half of the light samples, color + half_difference, against that from
// the other half, color - half_difference.
double self_error(const std::vector<glm::vec4>& color, const std::vector<glm::vec3>& half_difference) {
  double sum = 0;
  for (size_t i = 0; i < color.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double mean = color[i][c], half = half_difference[i][c];
      const double reference = mean - half, difference = 2.0 * half;
      sum += difference * difference / (reference * reference + 0.01);
    }
  return color.empty() ? 0.0 : sum / (3.0 * static_cast<double>(color.size()));
}

}  // namespace

void state_self_error(uint32_t light_samples, const std::vector<glm::vec4>& color,
                      const std::vector<glm::vec3>& half_difference, sideray_render_stats& stats) {
  stats.reference_light_samples = light_samples;
  stats.reference_self_error = light_samples > 1 ? self_error(color, half_difference) : -1.0;
}

}  // namespace sideray::bridge
