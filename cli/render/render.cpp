#include "cli/render/render.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/options/comparison.h"
#include "cli/plan/choice.h"
#include "cli/record/sidecar.h"
#include "cli/render/frames.h"
#include "cli/render/render_run.h"
#include "cli/session/picture_files.h"
#include "cli/session/session.h"
#include "cli/session/truth_file.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

void check_outputs(const RenderOptions& options) {
  if (options.named.render().translucency->check && options.stats.empty())
    wrong_usage("--diagnose check: its counts go into the statistics; give --stats FILE too");
  require_writable(options.output);
  if (!options.stats.empty()) require_writable(options.stats);
  if (!options.truth.empty()) require_writable(options.truth);
}

void check_reference(const RenderOptions& options) {
  if (options.reference.empty()) return;
  const scenes::Image reference = scenes::read_image(options.reference);
  if (reference.width != options.width() || reference.height != options.height())
    wrong_usage("--compare {}: is {}x{}, the picture {}x{}; give --size {}x{}", options.reference, reference.width,
                reference.height, options.width(), options.height(), reference.width, reference.height);
}

bool has_picture(const RenderOptions& options, const RunJob* job) {
  if (!has_truth(options)) return false;
  if (job) return made_picture(options.output, job->options).has_value();
  return is_picture(options.output, options.width(), options.height());
}

bool is_done(const RenderOptions& options, const RunJob* job) {
  std::error_code ignored;
  return has_picture(options, job) &&
         (options.stats.empty() || std::filesystem::is_regular_file(options.stats, ignored));
}

void draw(const RenderOptions& asked, const RunJob* job) {
  const bool is_kept = asked.resume && has_picture(asked, job);
  Session session(asked);
  const RenderOptions options = with_choice(session, asked);
  const Session::Drawn drawn = session.draw(options);
  if (!is_kept) {
    write_picture(drawn.picture, drawn.light_names, options);
    write_truth(session, options, 1);
  }
  const nlohmann::ordered_json stats = stats_json(options, drawn.run);
  if (job) write_sidecar(options.output, job->options, job->shard, stats, false);
  if (!options.stats.empty()) write_text(options.stats, scenes::json_text(stats, 2) + "\n");
}

// Returns the options chosen for the sequence's first frame, for all frames.
RenderOptions with_choice_of_first(const RenderOptions& sequence) {
  RenderOptions first = sequence;
  first.time_s = sequence.frames->time_s(sequence.frames->first);
  Session session(first);
  return with_choice(session, sequence);
}

// Refuses what cannot be drawn before anything is recorded.
int render_frames_run(const RenderOptions& asked) {
  std::vector<RenderOptions> renders{asked};
  prepare_run(renders);
  check_frames(renders[0]);
  SceneChecks().check(renders[0]);
  return render_run(renders, asked.frames->shard,
                    [&](size_t, const RunJob& job) { return render_frames(renders[0], &job); });
}

}  // namespace

void check_render(const RenderOptions& options) {
  if (options.frames) return check_frames(options);
  check_outputs(options);
  check_reference(options);
}

int render(const RenderOptions& options, const RunJob* job) {
  if (options.frames && options.frames->shard.is_recorded()) return render_frames_run(options);
  if (options.frames) return render_frames(options.bounds.any() ? with_choice_of_first(options) : options, job);
  check_render(options);
  if (options.resume && is_done(options, job))
    fmt::print("{}: exists; nothing to draw\n", options.output);
  else
    draw(options, job);
  if (options.reference.empty()) return exit_ok;
  return run_comparison(options.output, options.reference, {}, options.display);
}

}  // namespace sideray::cli
