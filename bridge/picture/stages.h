// Names the stages of a picture and keeps how long each took. Any thread.
#pragma once

#include <sideray/renderer.h>

#include <array>
#include <vector>

namespace sideray::bridge {

inline constexpr size_t stage_count = SIDERAY_STAGE_KEPT_FRAME + 1;

// As the statistics of the program call it; valid for ever.
const char* stage_name(sideray_stage stage);

class StageTimes {
 public:
  StageTimes();
  // Milliseconds; quartiles by linear interpolation between order statistics, zeros for no values.
  void set(sideray_stage stage, std::vector<double> values);
  void set(sideray_stage stage, double ms) { set(stage, std::vector<double>{ms}); }
  const std::array<sideray_stage_time, stage_count>& all() const { return times_; }

 private:
  std::array<sideray_stage_time, stage_count> times_{};
};

}  // namespace sideray::bridge
