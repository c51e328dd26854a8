// Measures the error of a sequence: the means of its frames' metrics, and errors that only motion shows (docs/cli.md,
// chart). Plain memory; one thread at a time may use an object.
#pragma once

#include <algorithm>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "lab/metrics/flicker.h"
#include "lab/metrics/metrics.h"
#include "lab/metrics/temporal.h"

namespace sideray::lab {

class SequenceError {
 public:
  // `frames` is the length of the sequence. Differences between frames skip the first half of it, at most
  // SettleMeter::period frames: methods with a history begin without one.
  explicit SequenceError(uint32_t frames, const Display& display = {})
      : first_looked_at_(std::min((std::max(frames, 1u) - 1) / 2, SettleMeter::period)),
        display_(display),
        flicker_(display),
        warp_(display) {}

  // Adds the next frame. `motion` is as WarpMeter takes it.
  void add(const scenes::Image& test, const scenes::Image& reference, const scenes::Image& motion);
  // Adds one of the SettleMeter::held pictures at rest, which follow the last frame. A method without a history needs
  // none.
  void add_at_rest(const scenes::Image& picture);

  // Returns all measures. Those that do not apply to a single frame are absent, and where a pixel is not finite those
  // of changes over time.
  nlohmann::ordered_json result() const;

 private:
  uint32_t first_looked_at_;
  Display display_;
  uint32_t frames_ = 0;
  uint64_t nonfinite_ = 0;
  std::map<std::string, double> sums_;  // for the metrics that all frames have
  FlickerMeter flicker_;
  WarpMeter warp_;
  scenes::Image last_;
  std::optional<SettleMeter> settle_;
};

}  // namespace sideray::lab
