#include "cli/chart/chart_sequence.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "cli/render/frames.h"
#include "cli/session/picture_files.h"
#include "lab/metrics/sequence_error.h"

namespace sideray::cli {

using lab::Json;

ChartSequence::ChartSequence(const ChartOptions& options, const ChartFolder& folder, Session& session)
    : options_(options),
      folder_(folder),
      session_(session),
      frames_(*options.frames),
      reference_pattern_(folder.path(folder.reference_output())),
      motion_pattern_(folder.path(ChartFolder::motion_output())) {}

Session::Drawn ChartSequence::draw_frame(const RenderOptions& frame) {
  session_.move_to(frame);
  return session_.draw(frame);
}

// Draws motion for all frames, or keeps it for all, since each frame depends on the one before.
void ChartSequence::draw_motion(bool keeps) {
  const RenderOptions sequence = resolve_motion(options_, motion_pattern_);
  const auto is_there = [&](uint32_t frame) {
    return is_picture(frame_path(motion_pattern_, frame), sequence.width(), sequence.height());
  };
  uint32_t kept = frames_.first;
  while (keeps && kept <= frames_.last && is_there(kept)) ++kept;
  if (kept > frames_.last) return;
  for (uint32_t frame = frames_.first; frame <= frames_.last; ++frame) {
    const RenderOptions options = frame_options(sequence, {frame, true, frame > frames_.first});
    const Session::Drawn drawn = draw_frame(options);
    write_picture(drawn.picture, drawn.light_names, options);
  }
}

lab::ChartReference ChartSequence::draw_reference(Progress& progress) {
  const RenderOptions sequence = resolve_reference(options_, reference_pattern_);
  std::optional<lab::ChartReference> kept;
  if (options_.resume || options_.shard.count > 1) kept = folder_.restore_reference();
  lab::ChartReference reference = kept.value_or(lab::ChartReference{folder_.reference_image(), 0, {}});
  // From here on the files in the folder belong to this chart.
  if (!kept) folder_.save_reference(reference);
  progress.next("motion");
  draw_motion(kept.has_value());
  std::vector<double>& errors = reference.self_errors;
  for (uint32_t frame = frames_.first; frame <= frames_.last; ++frame) {
    const size_t place = frame - frames_.first;
    const RenderOptions options = frame_options(sequence, {frame, true, false});
    progress.next(fmt::format("reference: frame {}", frame));
    if (place < errors.size() && is_picture(options.output, options.width(), options.height())) continue;
    const Session::Drawn drawn = draw_frame(options);
    write_picture(drawn.picture, drawn.light_names, options);
    errors.resize(std::max(errors.size(), place + 1));
    errors[place] = drawn.run.stats.reference_self_error;
    reference.light_samples = drawn.run.stats.reference_light_samples;
    reference.bounces = drawn.run.stats.reference_bounces;
    reference.caustics = drawn.run.stats.reference_caustics != 0;
    folder_.save_reference(reference);
  }
  if (std::all_of(errors.begin(), errors.end(), [](double error) { return error >= 0; }))
    reference.self_error = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  return reference;
}

// Compares the written files, so that `sideray render --frames` and `compare` give the same error.
Json ChartSequence::draw(const RenderOptions& sequence, const std::string& picture) {
  lab::SequenceError error(frames_.count(), sequence.display);
  for (uint32_t frame = frames_.first; frame <= frames_.last; ++frame) {
    RenderOptions options = frame_options(sequence, {frame, true, frame > frames_.first});
    options.output = picture;
    const Session::Drawn drawn = draw_frame(options);
    write_picture(drawn.picture, drawn.light_names, options);
    error.add(scenes::read_image(picture), scenes::read_image(frame_path(reference_pattern_, frame)),
              scenes::read_image(frame_path(motion_pattern_, frame)));
  }
  if (!has_past(sequence)) return error.result();
  for (uint32_t k = 1; k <= lab::SettleMeter::held; ++k) {
    RenderOptions options = frame_options(sequence, {frames_.last + k, true, true});
    options.time_s = frames_.time_s(frames_.last);
    options.frames.reset();  // time stands still
    const Session::Drawn drawn = draw_frame(options);
    error.add_at_rest(image_of(drawn.picture, drawn.light_names, options));
  }
  return error.result();
}

std::vector<Json> ChartSequence::measure(const RenderOptions& sequence) {
  std::vector<Json> stats;
  for (uint32_t frame = frames_.first; frame <= frames_.last; ++frame) {
    RenderOptions options = frame_options(sequence, {frame, true, frame > frames_.first});
    options.repeats = 1;
    stats.push_back(stats_json(options, draw_frame(options).run));
  }
  return stats;
}

}  // namespace sideray::cli
