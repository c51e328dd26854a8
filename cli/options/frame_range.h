// Says which frames of a sequence are drawn, at which times, and into which files. Any thread.
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
  uint32_t warm_up = 0;  // applies with a temporal method

  uint32_t count() const { return last - first + 1; }
  double time_s(uint32_t frame) const { return frame / fps; }
};

// Reads --frames, --fps, --shard and --warm-up; empty for a single picture. Throws UsageError.
std::optional<FrameRange> frame_range(const Given& given);

// Throws UsageError unless the file's name has exactly one run of #.
void check_frame_pattern(const std::string& pattern, const char* option = "-o");
// Replaces the run of # by the number, padded with zeros to its length; longer numbers are not cut.
std::string frame_path(const std::string& pattern, uint32_t frame);

}  // namespace sideray::cli
