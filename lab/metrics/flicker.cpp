#include "lab/metrics/flicker.h"

#include <fmt/format.h>

#include <sideray/sideray.hpp>

namespace sideray::lab {
namespace {

void add_to(std::vector<double>& sum, std::vector<double>& square, const std::vector<float>& values) {
  sum.resize(values.size()), square.resize(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const double v = double{values[i]};
    sum[i] += v, square[i] += v * v;
  }
}

double variances(const std::vector<double>& sum, const std::vector<double>& square, double frames) {
  double total = 0;
  for (size_t i = 0; i < sum.size(); ++i) total += (square[i] - sum[i] * sum[i] / frames) / frames;
  return total;
}

}  // namespace

void FlickerMeter::add(const scenes::Image& test, const scenes::Image& reference) {
  std::vector<float> now = scenes::display_values(test, display_.exposure_ev, display_.tonemap);
  std::vector<float> wanted = scenes::display_values(reference, display_.exposure_ev, display_.tonemap);
  if (now.size() != wanted.size() || (frames_ > 0 && now.size() != last_test_.size()))
    throw Error(SIDERAY_INVALID_ARGUMENT,
                fmt::format("frame {} of a sequence: its size differs from the others'; compare equal sizes", frames_));
  for (size_t i = 0; frames_ > 0 && i < now.size(); ++i) {
    const double step = double{now[i]} - double{last_test_[i]};
    const double reference_step = double{wanted[i]} - double{last_reference_[i]};
    test_steps_ += step * step;
    reference_steps_ += reference_step * reference_step;
    error_steps_ += (step - reference_step) * (step - reference_step);
  }
  add_to(sum_, square_, now);
  add_to(reference_sum_, reference_square_, wanted);
  last_test_ = std::move(now), last_reference_ = std::move(wanted);
  ++frames_;
}

Flicker FlickerMeter::result() const {
  Flicker flicker;
  flicker.frames = frames_;
  if (frames_ < 2) return flicker;
  const auto values = static_cast<double>(last_test_.size()), steps = values * (frames_ - 1);
  flicker.energy = 0.5 * test_steps_ / steps;
  flicker.reference_energy = 0.5 * reference_steps_ / steps;
  flicker.error_energy = 0.5 * error_steps_ / steps;
  flicker.excess_variance =
      (variances(sum_, square_, frames_) - variances(reference_sum_, reference_square_, frames_)) / values;
  return flicker;
}

}  // namespace sideray::lab
