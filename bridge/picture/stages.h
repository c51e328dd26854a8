// Names the stages of a picture and stores their times. Any thread.
#pragma once

#include <sideray/renderer.h>

#include <array>
#include <vector>

namespace sideray::bridge {

inline constexpr size_t stage_count = SIDERAY_STAGE_KEPT_FRAME + 1;

// Returns the stage's name in the program's statistics, as static text.
const char* stage_name(sideray_stage stage);

class StageTimes {
 public:
  StageTimes();
  // Sets milliseconds; quartiles are interpolated linearly between order statistics; 0 without values.
  void set(sideray_stage stage, std::vector<double> values);
  void set(sideray_stage stage, double ms) { set(stage, std::vector<double>{ms}); }
  const std::array<sideray_stage_time, stage_count>& all() const { return times_; }

 private:
  std::array<sideray_stage_time, stage_count> times_{};
};

}  // namespace sideray::bridge
