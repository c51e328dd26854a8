// Measures how much a sequence of pictures flickers beyond the changes in the reference's pictures. Plain memory; one
// thread at a time may use a meter.
#pragma once

#include <cstdint>
#include <vector>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// All values are in PNG values, and means over pixels and channels.
struct Flicker {
  uint32_t frames = 0;
  // Half the mean square of the change from one frame to the next: the variance of noise that is new in every frame
  // (von Neumann 1941), 0 for still pictures, little for slow changes.
  double energy = 0, reference_energy = 0;
  // The same of the difference between picture and reference: correct motion is in both and cancels, so that this shows
  // flicker that blur hides from `energy - reference_energy`.
  double error_energy = 0;
  // The variance of each value over all frames, less that of the reference.
  double excess_variance = 0;

  double excess_energy() const { return energy - reference_energy; }
};

class FlickerMeter {
 public:
  FlickerMeter() = default;
  explicit FlickerMeter(const Display& display) : display_(display) {}

  // Adds the sequence's next pictures. Throws Error where their size differs from the others' or R, G or B is missing.
  void add(const scenes::Image& test, const scenes::Image& reference);

  // Returns zeros for a single frame: nothing changes in it.
  Flicker result() const;

 private:
  Display display_;
  uint32_t frames_ = 0;
  std::vector<float> last_test_, last_reference_;
  double test_steps_ = 0, reference_steps_ = 0, error_steps_ = 0;        // sums of squares
  std::vector<double> sum_, square_, reference_sum_, reference_square_;  // for each value, over time
};

}  // namespace sideray::lab
