// Measures what shows in time alone: what follows motion and is not as before, and what of the past stays in a picture
// after everything stands still. Measures of docs/cli.md, chart. Plain memory; one thread at a time may use a meter.
#pragma once

#include <sideray/renderer.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// Holds half the mean square of the change of PNG values along the motion, from a frame to the next. For noise that is
// new in every frame that is its variance, where the motion is of whole pixels; for what moves and stays as it is, 0.
struct Warped {
  double difference = 0, reference_difference = 0;
  double share = 0;  // of the pixels: those that the frame before shows too

  double excess() const { return difference - reference_difference; }
};

class WarpMeter {
 public:
  explicit WarpMeter(const Display& display = {}) : display_(display) {}

  // Adds the sequence's next pictures. `motion`: planes motion.X, motion.Y, Z and id.surface of what both show. Throws
  // Error where sizes differ or a plane is missing.
  void add(const scenes::Image& test, const scenes::Image& reference, const scenes::Image& motion);

  Warped result() const;

 private:
  Display display_;
  uint32_t frames_ = 0;
  std::vector<float> test_, reference_;  // the frame before
  std::vector<float> distance_;
  std::vector<uint32_t> surface_;
  double test_squares_ = 0, reference_squares_ = 0;
  uint64_t compared_ = 0, pixels_ = 0;
};

struct Settling {
  double ghost = 0;        // root mean square of PNG values between the first picture and the settled one
  double half_life = 0;    // frames until the ghost is half as strong
  double settle_time = 0;  // frames until it stays at or below the tolerance
};

// Takes a picture in motion and those after everything has come to rest. The last `period` of them are the settled
// picture, each for those of its own place in the period; what the `period` before still differ from them by, noise for
// the most part, is taken off all squares.
class SettleMeter {
 public:
  static constexpr uint32_t period = SIDERAY_JITTER_PERIOD;  // frames
  static constexpr uint32_t held = 6 * period;    // pictures drawn at rest
  static constexpr double tolerance = 1.0 / 255;  // root mean square of PNG values

  explicit SettleMeter(const Display& display = {}) : display_(display) {}

  // Adds first the last picture in motion, then `held` at rest. Throws Error where sizes differ.
  void add(const scenes::Image& picture);

  // Throws Error before all are there.
  Settling result() const;

 private:
  std::vector<double> ghosts() const;

  Display display_;
  std::vector<std::vector<uint16_t>> pictures_;  // PNG values in 1/65535
};

// Returns the names of the measures in time beside the metrics, in the order of docs/cli.md; the smaller the better,
// all of them.
const std::vector<std::string>& temporal_names();

}  // namespace sideray::lab
