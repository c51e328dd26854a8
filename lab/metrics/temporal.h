// Measures errors that only motion shows: changes of surfaces along their motion, and ghosts that remain after
// everything has stopped (docs/cli.md, chart). Plain memory; one thread at a time may use a meter.
#pragma once

#include <sideray/renderer.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// Holds half the mean square of the change of PNG values along the motion, from one frame to the next. That is the
// variance of noise that is new in every frame, if motion is by whole pixels, and 0 for surfaces that move unchanged.
struct Warped {
  double difference = 0, reference_difference = 0;
  double share = 0;  // of the pixels whose surface the previous frame shows too

  double excess() const { return difference - reference_difference; }
};

class WarpMeter {
 public:
  explicit WarpMeter(const Display& display = {}) : display_(display) {}

  // Adds the sequence's next pictures. `motion` has the planes motion.X, motion.Y, Z and id.surface of the same view.
  // Throws Error where sizes differ or a plane is missing.
  void add(const scenes::Image& test, const scenes::Image& reference, const scenes::Image& motion);

  Warped result() const;

 private:
  Display display_;
  uint32_t frames_ = 0;
  std::vector<float> test_, reference_;  // of the previous frame
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

// Takes the last picture in motion and those at rest. The last `period` pictures are the settled ones: each is compared
// with the pictures at its place in the period. The mean square difference of the `period` pictures before them, mostly
// noise, is subtracted from all squares.
class SettleMeter {
 public:
  static constexpr uint32_t period = SIDERAY_JITTER_PERIOD;  // frames
  static constexpr uint32_t held = 6 * period;    // pictures drawn at rest
  static constexpr double tolerance = 1.0 / 255;  // root mean square of PNG values

  explicit SettleMeter(const Display& display = {}) : display_(display) {}

  // Adds first the last picture in motion, then `held` at rest. Throws Error where sizes differ.
  void add(const scenes::Image& picture);

  // Throws Error before all pictures are added.
  Settling result() const;

 private:
  std::vector<double> ghosts() const;

  Display display_;
  std::vector<std::vector<uint16_t>> pictures_;  // PNG values in 1/65535
};

// Returns the names of the measures over time, in the order of docs/cli.md. Of all of them smaller values are better.
const std::vector<std::string>& temporal_names();

}  // namespace sideray::lab
