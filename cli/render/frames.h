// Sequences: which frames, when each is, and where its picture goes. Any thread but render_frames: main thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/options/options.h"
#include "cli/options/sequence_plan.h"

namespace sideray::cli {

struct RenderOptions;

struct FrameRange {
  uint32_t first = 0, last = 0;  // inclusive
  double fps = 30;
  Shard shard;
  uint32_t warm_up = 0;  // where a temporal method is on

  uint32_t count() const { return last - first + 1; }
  double time_s(uint32_t frame) const { return frame / fps; }
};

// Of --frames, --fps, --shard and --warm-up; empty for a single picture. Throws UsageError.
std::optional<FrameRange> frame_range(const Given& given);

// Of I/N. Throws UsageError.
Shard parse_shard(const std::string& text);

// Throws UsageError where the file's name has not exactly one run of #.
void check_frame_pattern(const std::string& pattern);
// The run of # replaced by the number, padded with zeros to its length; longer numbers stay whole.
std::string frame_path(const std::string& pattern, uint32_t frame);

// One frame of a sequence as the picture that it is.
RenderOptions frame_options(const RenderOptions& sequence, const Step& step);
// Whether a picture depends on those before it.
bool has_past(const RenderOptions& sequence);

// Throws UsageError or Error where the files of the sequence cannot be written, or two of them are one.
void check_frames(const RenderOptions& options);
// Draws and writes the frames of the shard in turn, with --resume those that are missing; their stats are one object a
// line. Returns the exit code.
int render_frames(const RenderOptions& options);

}  // namespace sideray::cli
