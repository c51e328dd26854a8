#include "frames.h"

#include "failure.h"
#include "outputs.h"
#include "picture_files.h"
#include "progress.h"
#include "session.h"

namespace sideray::cli {
namespace {

constexpr uint32_t largest_frame = 9999999, most_frames = 1000000;

// Of the one picture that a frame is.
RenderOptions options_of(const RenderOptions& sequence, uint32_t frame) {
  RenderOptions options = sequence;
  options.output = frame_path(sequence.output, frame);
  options.time_s = sequence.frames->time_s(frame);
  options.given["time"] = fmt::format("{}", options.time_s);
  options.options.continues = frame != sequence.frames->first;
  return options;
}

void check_paths(const RenderOptions& options) {
  const FrameRange& frames = *options.frames;
  for (uint32_t frame = frames.first; frame <= frames.last; ++frame)
    require_distinct({{"-o", frame_path(options.output, frame)}, {"--stats", options.stats}}, {});
  require_writable(frame_path(options.output, frames.first));
  if (!options.stats.empty()) require_writable(options.stats);
}

}  // namespace

std::optional<FrameRange> frame_range(const Given& given) {
  const auto frames = given.find("frames");
  if (frames == given.end()) {
    if (given.contains("fps")) wrong_usage("--fps: a single picture has no rate; give --frames too");
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
  if (given.contains("fps")) range.fps = number("fps", given.at("fps"), 1e-3, 1e6);
  return range;
}

void check_frame_pattern(const std::string& pattern) {
  const size_t first = pattern.find('#');
  if (first == std::string::npos)
    wrong_usage("-o {}: has no place for the frame's number; write for example name.####.exr", pattern);
  const size_t end = std::min(pattern.find_first_not_of('#', first), pattern.size());
  if (pattern.find('#', end) != std::string::npos)
    wrong_usage("-o {}: has several runs of #; keep one for the frame's number", pattern);
}

std::string frame_path(const std::string& pattern, uint32_t frame) {
  const size_t first = pattern.find('#');
  const size_t end = std::min(pattern.find_first_not_of('#', first), pattern.size());
  return fmt::format("{}{:0{}}{}", pattern.substr(0, first), frame, end - first, pattern.substr(end));
}

int render_frames(const RenderOptions& options) {
  check_paths(options);
  const FrameRange& frames = *options.frames;
  Session session(options_of(options, frames.first));
  std::string stats;
  Progress progress(frames.count());
  for (uint32_t frame = frames.first; frame <= frames.last; ++frame) {
    const RenderOptions picture = options_of(options, frame);
    progress.next(picture.output);
    session.move_to(picture);
    const Session::Drawn drawn = session.draw(picture);
    write_picture(drawn.picture, picture);
    if (options.stats.empty()) continue;
    nlohmann::ordered_json line = {{"frame", frame}};
    line.update(stats_json(picture, drawn.run));
    stats += line.dump() + "\n";
  }
  if (!options.stats.empty()) write_text(options.stats, stats);
  return exit_ok;
}

}  // namespace sideray::cli
