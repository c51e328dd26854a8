#include "lab/golden/light_factor.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sideray::lab {
namespace {

// Darker values have too few digits to divide by.
constexpr double least_value = 0.02;
constexpr double least_change = 0.002;
constexpr double fitting_share = 0.99;
constexpr double most_left = 0.4;  // of the difference

double linear_of(double display) {
  return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}
double display_of(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

struct Values {
  std::vector<double> now, reference;
};

std::optional<Values> colours_of(const scenes::Image& now, const scenes::Image& reference) {
  Values values;
  for (const char* name : {"R", "G", "B"}) {
    const scenes::Plane *a = now.find(name), *b = reference.find(name);
    if (!a || !b) return {};
    for (const float v : a->values) values.now.push_back(double{v});
    for (const float v : b->values) values.reference.push_back(double{v});
  }
  const auto is_finite = [](double v) { return std::isfinite(v); };
  if (!std::all_of(values.now.begin(), values.now.end(), is_finite) ||
      !std::all_of(values.reference.begin(), values.reference.end(), is_finite))
    return {};
  return values;
}

std::optional<double> median_ratio(const Values& values, bool linear) {
  std::vector<double> ratios;
  for (size_t i = 0; i < values.now.size(); ++i) {
    const double now = linear ? values.now[i] : linear_of(values.now[i]);
    const double before = linear ? values.reference[i] : linear_of(values.reference[i]);
    // What is white stays white.
    if (before > least_value && (linear || values.reference[i] < 1.0)) ratios.push_back(now / before);
  }
  if (ratios.empty()) return {};
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

// Half floats round by 2^-11, display values by half a 255th and the tone curve's bend.
double tolerance(double expected, bool linear) {
  return linear ? 0.002 * std::abs(expected) + 1e-4 : 2.0 / 255;
}

struct Fit {
  double error = 0;  // sum
  size_t values = 0; // within the tolerance
};

Fit fit_of(const Values& values, double factor, bool linear) {
  Fit fit;
  for (size_t i = 0; i < values.now.size(); ++i) {
    const double before = values.reference[i];
    const double expected = linear ? factor * before : std::min(display_of(factor * linear_of(before)), 1.0);
    const double error = std::abs(values.now[i] - expected);
    fit.error += error;
    fit.values += error <= tolerance(expected, linear);
  }
  return fit;
}

}  // namespace

std::optional<double> light_factor(const scenes::Image& now, const scenes::Image& reference) {
  const std::optional<Values> values = colours_of(now, reference);
  if (!values) return {};
  const std::optional<double> factor = median_ratio(*values, now.linear);
  if (!factor || std::abs(*factor - 1) < least_change) return {};
  const Fit fit = fit_of(*values, *factor, now.linear);
  // Noise, and a change of a few pixels, fit a factor of 1 nearly as well.
  if (fit.error > most_left * fit_of(*values, 1, now.linear).error) return {};
  if (static_cast<double>(fit.values) < fitting_share * static_cast<double>(values->now.size())) return {};
  return factor;
}

}  // namespace sideray::lab
