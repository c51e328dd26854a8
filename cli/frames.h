// Sequences: which frames, when each is, and where its picture goes. Any thread but render_frames: main thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "options.h"

namespace sideray::cli {

struct RenderOptions;

struct FrameRange {
  uint32_t first = 0, last = 0;  // inclusive
  double fps = 30;

  uint32_t count() const { return last - first + 1; }
  double time_s(uint32_t frame) const { return frame / fps; }
};

// Of --frames and --fps; empty for a single picture. Throws UsageError.
std::optional<FrameRange> frame_range(const Given& given);

// Throws UsageError where the file's name has not exactly one run of #.
void check_frame_pattern(const std::string& pattern);
// The run of # replaced by the number, padded with zeros to its length; longer numbers stay whole.
std::string frame_path(const std::string& pattern, uint32_t frame);

// Draws and writes the frames in turn; their stats are one object a line. Returns the exit code.
int render_frames(const RenderOptions& options);

}  // namespace sideray::cli
