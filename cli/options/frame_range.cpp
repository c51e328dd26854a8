#include "cli/options/frame_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cli/base/failure.h"
#include "cli/options/render_table.h"

namespace sideray::cli {
namespace {

constexpr uint32_t largest_frame = 9999999, most_frames = 1000000;

}  // namespace

std::optional<FrameRange> frame_range(const Given& given) {
  const auto frames = given.find("frames");
  if (frames == given.end()) {
    for (const char* other : {"fps", "shard", "warm-up"})
      if (given.contains(other)) wrong_usage("--{}: a single picture is no sequence; give --frames too", other);
    return std::nullopt;
  }
  for (const char* other : {"time", "compare"})
    if (given.contains(other)) wrong_usage("--{}: contradicts --frames; leave one of them out", other);
  const std::vector<std::string> ends = split(frames->second, '-');
  if (ends.size() != 2 || ends[0].empty() || ends[1].empty())
    wrong_usage("--frames: \"{}\" is not A-B; write for example 0-63", frames->second);
  FrameRange range;
  range.first = whole_number("frames", ends[0], 0, largest_frame);
  range.last = whole_number("frames", ends[1], 0, largest_frame);
  if (range.last < range.first) wrong_usage("--frames: {} ends before it begins; write A-B", frames->second);
  if (range.count() > most_frames) wrong_usage("--frames: {} are too many; at most {}", frames->second, most_frames);
  range.fps = number_of(render_table(), given, "fps");
  if (given.contains("shard")) range.shard = parse_shard(given.at("shard"));
  range.warm_up = whole_number_of(render_table(), given, "warm-up");
  return range;
}

void check_frame_pattern(const std::string& pattern, const char* option) {
  const size_t first = pattern.find('#');
  if (first == std::string::npos)
    wrong_usage("{} {}: has no place for the frame's number; write for example name.####{}", option, pattern,
                std::filesystem::path(pattern).extension().string());
  const size_t end = std::min(pattern.find_first_not_of('#', first), pattern.size());
  if (pattern.find('#', end) != std::string::npos)
    wrong_usage("{} {}: has several runs of #; keep one for the frame's number", option, pattern);
}

std::string frame_path(const std::string& pattern, uint32_t frame) {
  const size_t first = pattern.find('#');
  const size_t end = std::min(pattern.find_first_not_of('#', first), pattern.size());
  return fmt::format("{}{:0{}}{}", pattern.substr(0, first), frame, end - first, pattern.substr(end));
}

}  // namespace sideray::cli
