// How much a sequence of pictures flickers beyond what the reference's own pictures change. Plain memory; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// All of PNG values, means over pixels and channels.
struct Flicker {
  uint32_t frames = 0;
  // Half the mean square of the change from a frame to the next: of noise that is new in every frame its variance (von
  // Neumann 1941), of what stands still 0, of slow changes little.
  double energy = 0, reference_energy = 0;
  // The same of what is between picture and reference: right motion is in both and does not count, so that it sees
  // flicker that blur hides from `energy - reference_energy`.
  double error_energy = 0;
  // Over all frames, of each value in time, less the reference's.
  double excess_variance = 0;

  double excess_energy() const { return energy - reference_energy; }
};

class FlickerMeter {
 public:
  FlickerMeter() = default;
  explicit FlickerMeter(const Display& display) : display_(display) {}

  // The sequence's next pictures. Throws Error where their size differs from the others' or R, G or B is missing.
  void add(const scenes::Image& test, const scenes::Image& reference);

  // Zeros for a single frame: nothing changes in it.
  Flicker result() const;

 private:
  Display display_;
  uint32_t frames_ = 0;
  std::vector<float> last_test_, last_reference_;
  double test_steps_ = 0, reference_steps_ = 0, error_steps_ = 0;        // sums of squares
  std::vector<double> sum_, square_, reference_sum_, reference_square_;  // of each value in time
};

}  // namespace sideray::lab
