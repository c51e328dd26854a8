// Measures the error of a sequence: means of its frames' metrics, and temporal measures (docs/cli.md, chart). Plain
// memory; one thread at a time may use an object.
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
  // The sequence has `frames` frames. Temporal measures skip the first ones, half of them but at most
  // SettleMeter::period, because methods with a history start without one.
  explicit SequenceError(uint32_t frames, const Display& display = {})
      : first_looked_at_(std::min((std::max(frames, 1u) - 1) / 2, SettleMeter::period)),
        display_(display),
        flicker_(display),
        warp_(display) {}

  // Adds the next frame. `motion` is as in WarpMeter.
  void add(const scenes::Image& test, const scenes::Image& reference, const scenes::Image& motion);
  // Adds a picture at rest, after the last frame; SettleMeter::held of them are needed. Without any, the method counts
  // as having no history.
  void add_at_rest(const scenes::Image& picture);

  // Returns the measures. Those that do not apply to one frame are absent; so are all temporal measures if a pixel is
  // not finite.
  nlohmann::ordered_json result() const;

 private:
  uint32_t first_looked_at_;
  Display display_;
  uint32_t frames_ = 0;
  uint64_t nonfinite_ = 0;
  std::map<std::string, double> sums_;  // of the metrics that all frames have
  FlickerMeter flicker_;
  WarpMeter warp_;
  scenes::Image last_;
  std::optional<SettleMeter> settle_;
};

}  // namespace sideray::lab
