// Which frames of a sequence are drawn, when each is, and where its picture goes. Any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/options/options.h"
#include "cli/options/shard.h"

namespace sideray::cli {

struct FrameRange {
  uint32_t first = 0, last = 0;  // inclusive
  double fps = 30;
  TaskShard shard;
  uint32_t warm_up = 0;  // where a temporal method is on

  uint32_t count() const { return last - first + 1; }
  double time_s(uint32_t frame) const { return frame / fps; }
};

// Of --frames, --fps, --shard and --warm-up; empty for a single picture. Throws UsageError.
std::optional<FrameRange> frame_range(const Given& given);

// Throws UsageError where the file's name has not exactly one run of #.
void check_frame_pattern(const std::string& pattern, const char* option = "-o");
// The run of # replaced by the number, padded with zeros to its length; longer numbers stay whole.
std::string frame_path(const std::string& pattern, uint32_t frame);

}  // namespace sideray::cli
