#include "bridge/picture/self_error.h"

#include <algorithm>
#include <functional>

namespace sideray::bridge {
namespace {

// Returns each pixel's relMSE (docs/cli.md) between the pictures of the two halves of the light samples, color +
// half_difference and color - half_difference.
std::vector<double> errors_of_pixels(const std::vector<glm::vec4>& color,
                                     const std::vector<glm::vec3>& half_difference) {
  std::vector<double> errors(color.size());
  for (size_t i = 0; i < color.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double mean = color[i][c], half = half_difference[i][c];
      const double reference = mean - half, difference = 2.0 * half;
      errors[i] += difference * difference / (reference * reference + 0.01);
    }
  return errors;
}

double sum_of(const std::vector<double>& errors, size_t first, size_t count) {
  double sum = 0;
  for (size_t i = first; i < first + count; ++i) sum += errors[i];
  return sum;
}

// Returns the largest thousandth's share of the sum of errors.
double firefly_share(std::vector<double> errors, double sum) {
  if (errors.empty() || !(sum > 0.0)) return 0.0;
  const size_t largest = (errors.size() + 999) / 1000;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(largest - 1), errors.end(),
                   std::greater<>());
  return sum_of(errors, 0, largest) / sum;
}

}  // namespace

void state_self_error(uint32_t light_samples, uint32_t bounces, const std::vector<glm::vec4>& color,
                      const std::vector<glm::vec3>& half_difference, sideray_render_stats& stats) {
  stats.reference_light_samples = light_samples;
  stats.reference_bounces = bounces;
  stats.reference_self_error = stats.reference_firefly_share = -1.0;
  if (light_samples < 2) return;
  const std::vector<double> errors = errors_of_pixels(color, half_difference);
  const double sum = sum_of(errors, 0, errors.size());
  stats.reference_self_error = errors.empty() ? 0.0 : sum / (3.0 * static_cast<double>(errors.size()));
  stats.reference_firefly_share = firefly_share(errors, sum);
}

}  // namespace sideray::bridge
