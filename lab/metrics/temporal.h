// Measures temporal artefacts: content that follows motion but changes, and ghosts of the past after everything has
// come to rest. docs/cli.md, chart, defines the measures. Plain memory; one thread at a time may use a meter.
#pragma once

#include <sideray/renderer.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// Half the mean square of the change of PNG values along the motion, between frames. It is the variance of noise that
// is new in every frame, if motion is in whole pixels, and 0 for content that moves unchanged.
struct Warped {
  double difference = 0, reference_difference = 0;
  double share = 0;  // of pixels whose surface is visible in the previous frame too

  double excess() const { return difference - reference_difference; }
};

class WarpMeter {
 public:
  explicit WarpMeter(const Display& display = {}) : display_(display) {}

  // Adds the sequence's next pictures. `motion`: planes motion.X, motion.Y, Z and id.surface, for both pictures. Throws
  // Error if sizes differ or a plane is missing.
  void add(const scenes::Image& test, const scenes::Image& reference, const scenes::Image& motion);

  Warped result() const;

 private:
  Display display_;
  uint32_t frames_ = 0;
  std::vector<float> test_, reference_;  // the previous frame
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

// Compares a picture in motion with pictures after everything has come to rest. The last `period` of these are the
// settled picture, one for each position in the period. The squared difference between them and the `period` before,
// mostly noise, is subtracted from all squares.
class SettleMeter {
 public:
  static constexpr uint32_t period = SIDERAY_JITTER_PERIOD;  // frames
  static constexpr uint32_t held = 6 * period;    // pictures drawn at rest
  static constexpr double tolerance = 1.0 / 255;  // root mean square of PNG values

  explicit SettleMeter(const Display& display = {}) : display_(display) {}

  // Adds the last picture in motion, then `held` pictures at rest. Throws Error if sizes differ.
  void add(const scenes::Image& picture);

  // Throws Error if pictures are missing.
  Settling result() const;

 private:
  std::vector<double> ghosts() const;

  Display display_;
  std::vector<std::vector<uint16_t>> pictures_;  // PNG values in 1/65535
};

// Returns the names of the temporal measures, in the order of docs/cli.md; for all of them smaller is better.
const std::vector<std::string>& temporal_names();

}  // namespace sideray::lab
