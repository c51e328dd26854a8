#include "lab/golden/light_factor.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sideray::lab {
namespace {

constexpr size_t most_pixels = 16384;  // evenly spaced samples
constexpr double most_stops = 6;
constexpr double least_change = 0.002;
// Rays toward faint lights are drawn with odds that follow their strength, so a few values differ by more than the factor.
constexpr double fitting_share = 0.98;
constexpr double most_left = 0.4;  // largest share of the difference that may remain

scenes::Image sampled(const scenes::Image& image) {
  const size_t pixels = size_t{image.width} * image.height, step = (pixels + most_pixels - 1) / most_pixels;
  scenes::Image samples{0, 1, {}, image.linear};
  for (const char* name : {"R", "G", "B"}) {
    const scenes::Plane* plane = image.find(name);
    if (!plane) return {};
    scenes::Plane few{name, plane->type, {}, {}};
    for (size_t i = 0; i < pixels; i += step) few.values.push_back(plane->values[i]);
    samples.width = static_cast<uint32_t>(few.values.size());
    samples.planes.push_back(std::move(few));
  }
  return samples;
}

// Returns three values a pixel in the reference's form, brightened by `stops`.
std::vector<float> values_of(const scenes::Image& image, double stops, bool linear, const Display& display) {
  if (!linear)
    return scenes::display_values(image, display.exposure_ev + static_cast<float>(stops), display.tonemap);
  std::vector<float> values;
  for (const scenes::Plane& plane : image.planes)
    for (const float v : plane.values) values.push_back(v * static_cast<float>(std::exp2(stops)));
  return values;
}

// Returns the stops at which as many values are above the reference as below it: the median, for any tone curve.
double median_stops(const scenes::Image& now, const std::vector<float>& reference, bool linear,
                    const Display& display) {
  double low = -most_stops, high = most_stops;
  for (int i = 0; i < 24; ++i) {
    const double middle = (low + high) / 2;
    const std::vector<float> values = values_of(now, middle, linear, display);
    int64_t above = 0;
    for (size_t k = 0; k < values.size(); ++k) above += (values[k] > reference[k]) - (values[k] < reference[k]);
    (above > 0 ? high : low) = middle;
  }
  return (low + high) / 2;
}

// Halfs round by 2^-11, display values by half a 255th.
double tolerance(float value, bool linear) {
  return linear ? 0.002 * std::abs(double{value}) + 1e-4 : 1.5 / 255;
}

struct Fit {
  double error = 0;   // sum
  size_t values = 0;  // within the tolerance
};

Fit fit_of(const std::vector<float>& values, const std::vector<float>& reference, bool linear) {
  Fit fit;
  for (size_t i = 0; i < values.size(); ++i) {
    const double error = std::abs(double{values[i]} - double{reference[i]});
    fit.error += error;
    fit.values += error <= tolerance(reference[i], linear);
  }
  return fit;
}

}  // namespace

std::optional<double> light_factor(const scenes::Image& now, const scenes::Image& reference, const Display& display) {
  const bool linear = reference.linear;
  const scenes::Image samples = sampled(now), reference_samples = sampled(reference);
  if (samples.planes.size() != 3 || reference_samples.width != samples.width) return {};
  const std::vector<float> wanted = values_of(reference_samples, 0, linear, display),
                           before = values_of(samples, 0, linear, display);
  const auto is_finite = [](float v) { return std::isfinite(v); };
  if (!std::all_of(wanted.begin(), wanted.end(), is_finite) || !std::all_of(before.begin(), before.end(), is_finite))
    return {};
  const double stops = median_stops(samples, wanted, linear, display), factor = std::exp2(-stops);
  if (std::abs(factor - 1) < least_change) return {};
  const Fit fit = fit_of(values_of(samples, stops, linear, display), wanted, linear);
  // Noise, or a change in a few pixels, would fit a factor of 1 nearly as well.
  if (fit.error > most_left * fit_of(before, wanted, linear).error) return {};
  if (static_cast<double>(fit.values) < fitting_share * static_cast<double>(wanted.size())) return {};
  return factor;
}

}  // namespace sideray::lab
