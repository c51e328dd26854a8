#include "cli/render/frames.h"

#include <nlohmann/json.hpp>
#include <set>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/progress.h"
#include "cli/record/sidecar.h"
#include "cli/render/sequence_stats.h"
#include "cli/session/picture_files.h"
#include "cli/session/session.h"
#include "cli/session/truth_file.h"

namespace sideray::cli {
namespace {

// Returns how many earlier frames a picture depends on, or settles over.
uint32_t warm_up_frames(const RenderOptions& options) {
  return has_past(options) ? options.frames->warm_up : 0;
}

// Draws the frames of the block in turn, and knows which pictures and stats exist.
class Sequence {
 public:
  Sequence(const RenderOptions& options, const RunJob* job)
      : options_(options),
        job_(job),
        block_(block_of(options.frames->first, options.frames->count(), options.frames->shard)),
        stats_(options.stats) {
    if (!options.resume) return;
    for (uint32_t frame = block_.begin; frame < block_.end; ++frame)
      if (is_there(frame)) kept_.insert(frame);
    const auto is_kept = [&](uint32_t frame) {
      return frame >= block_.begin && frame < block_.end ? kept_.contains(frame) : is_there(frame);
    };
    if (has_stats_file()) stats_.restore(is_kept);
  }

  bool has_frames() const { return block_.begin < block_.end; }
  // Returns the frames whose picture or stats are missing.
  std::vector<uint32_t> missing() const {
    std::vector<uint32_t> frames;
    for (uint32_t frame = block_.begin; frame < block_.end; ++frame)
      if (!kept_.contains(frame) || (has_stats_file() && !stats_.has(frame))) frames.push_back(frame);
    return frames;
  }

  void draw(const std::vector<Step>& steps) {
    // A framed camera stays where it is in the whole sequence's first frame.
    Session session(frame_options(options_, {options_.frames->first}));
    Progress progress(steps.size());
    for (const Step& step : steps) {
      const RenderOptions picture = frame_options(options_, step);
      progress.next(picture.output);
      session.move_to(picture);
      const Session::Drawn drawn = session.draw(picture);
      if (!step.is_wanted) continue;
      if (!kept_.contains(step.frame)) {
        write_picture(drawn.picture, drawn.light_names, picture);
        write_truth(session, picture, step.frame);
      }
      keep_stats(picture, step.frame, stats_json(picture, drawn.run));
    }
  }

  void save_stats() {
    if (has_stats_file()) stats_.save();
  }

 private:
  // Tasks of one run would overwrite each other's stats file, so they have none.
  bool has_stats_file() const { return !options_.stats.empty() && !job_; }

  void keep_stats(const RenderOptions& picture, uint32_t frame, const nlohmann::ordered_json& stats) {
    if (job_)
      write_sidecar(picture.output, picture_options(job_->options, frame), job_->shard, stats, !options_.stats.empty());
    else if (has_stats_file())
      stats_.add(frame, stats);
  }

  bool is_there(uint32_t frame) const {
    if (!options_.truth.empty() && !has_truth(frame_options(options_, {frame}))) return false;
    const std::string path = frame_path(options_.output, frame);
    if (job_) return made_picture(path, picture_options(job_->options, frame)).has_value();
    return is_picture(path, options_.width(), options_.height());
  }

  const RenderOptions& options_;
  const RunJob* job_;  // nullptr: no other tasks share the run
  Block block_;
  std::set<uint32_t> kept_;  // frames of the block whose pictures stay
  SequenceStats stats_;
};

}  // namespace

RenderOptions frame_options(const RenderOptions& sequence, const Step& step) {
  RenderOptions options = sequence;
  options.output = frame_path(sequence.output, step.frame);
  if (!sequence.truth.empty()) options.truth = frame_path(sequence.truth, step.frame);
  options.time_s = sequence.frames->time_s(step.frame);
  options.given["time"] = fmt::format("{}", options.time_s);
  options.continues = step.continues;
  // Only temporal averages need new random numbers in each frame; otherwise these would flicker.
  if (has_past(options))
    options.seed_offset = 0x9e3779b9u * (step.frame - sequence.frames->first);
  if (!step.is_wanted) options.repeats = 0;
  return options;
}

bool has_past(const RenderOptions& options) {
  return sideray_options_past(options.named.get()) != SIDERAY_PAST_NONE;
}

void check_frames(const RenderOptions& options) {
  const FrameRange& frames = *options.frames;
  for (uint32_t frame = frames.first; frame <= frames.last; ++frame)
    require_distinct({{"-o", frame_path(options.output, frame)},
                      {"--truth", options.truth.empty() ? "" : frame_path(options.truth, frame)},
                      {"--stats", options.stats}},
                     {});
  require_writable(frame_path(options.output, frames.first));
  if (!options.truth.empty()) require_writable(frame_path(options.truth, frames.first));
  if (!options.stats.empty()) require_writable(options.stats);
}

int render_frames(const RenderOptions& options, const RunJob* job) {
  check_frames(options);
  Sequence sequence(options, job);
  const std::vector<uint32_t> missing = sequence.missing();
  if (missing.empty())
    fmt::print("{}: {}; nothing to draw\n", options.output,
               sequence.has_frames() ? "the frames asked for exist" : "the shard has no frames");
  else
    sequence.draw(plan_steps(options.frames->first, missing, warm_up_frames(options),
                             options.named.render().taa ? uint32_t{SIDERAY_JITTER_PERIOD} : 1));
  sequence.save_stats();
  return exit_ok;
}

}  // namespace sideray::cli
