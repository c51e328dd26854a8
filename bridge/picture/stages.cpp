#include "bridge/picture/stages.h"

#include <algorithm>
#include <iterator>

namespace sideray::bridge {
namespace {

constexpr const char* names[] = {"load",     "build",  "update",    "gbuffer",     "shadow_map", "mask",
                                 "readback", "trace",  "trace_shadow", "trace_ao", "denoise",    "upload",
                                 "light",    "composite", "total_frame", "kept_frame"};
static_assert(std::size(names) == stage_count);

// `sorted` must not be empty.
double quantile(const std::vector<double>& sorted, double q) {
  const double position = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (sorted[above] - sorted[below]) * (position - static_cast<double>(below));
}

}  // namespace

const char* stage_name(sideray_stage stage) {
  return names[stage];
}

StageTimes::StageTimes() {
  for (size_t i = 0; i < stage_count; ++i) {
    const auto stage = static_cast<sideray_stage>(i);
    times_[i] = {stage, stage_name(stage), 0, 0, 0};
  }
}

void StageTimes::set(sideray_stage stage, std::vector<double> values) {
  sideray_stage_time& time = times_[stage];
  time.p25 = time.median = time.p75 = 0;
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  time.p25 = quantile(values, 0.25);
  time.median = quantile(values, 0.5);
  time.p75 = quantile(values, 0.75);
}

}  // namespace sideray::bridge
