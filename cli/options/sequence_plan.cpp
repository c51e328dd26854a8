#include "cli/options/sequence_plan.h"

#include <algorithm>

namespace sideray::cli {

Block block_of(uint32_t first, uint32_t frames, Shard shard) {
  const auto border = [&](uint64_t index) { return first + static_cast<uint32_t>(frames * index / shard.count); };
  return {border(shard.index), border(uint64_t{shard.index} + 1)};
}

std::vector<Step> plan_steps(uint32_t first, std::span<const uint32_t> wanted, uint32_t warm_up, uint32_t period) {
  std::vector<Step> steps;
  uint32_t next = first;  // the first frame that no earlier step draws
  for (const uint32_t frame : wanted) {
    uint32_t earliest = frame - std::min(warm_up, frame - first);
    if (warm_up >= period) earliest = first + (earliest - first + period - 1) / period * period;
    const uint32_t begin = std::max(next, earliest);
    for (uint32_t drawn = begin; drawn <= frame; ++drawn)
      steps.push_back({drawn, drawn == frame, !steps.empty() && steps.back().frame + 1 == drawn});
    next = frame + 1;
  }
  return steps;
}

}  // namespace sideray::cli
