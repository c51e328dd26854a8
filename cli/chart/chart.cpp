#include "cli/chart/chart.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/base/failure.h"
#include "cli/base/progress.h"
#include "cli/chart/chart_folder.h"
#include "cli/chart/chart_ledger.h"
#include "cli/chart/chart_report.h"
#include "cli/chart/chart_run.h"
#include "cli/chart/chart_sequence.h"
#include "cli/options/configuration_files.h"
#include "cli/plan/sweep_scene.h"
#include "cli/record/task_note.h"
#include "cli/render/frames.h"
#include "cli/session/picture_files.h"
#include "cli/session/session.h"
#include "cli/session/used_config.h"

namespace sideray::cli {
namespace {

using lab::ChartRow;
using lab::Json;

std::string entry_name(const ChartOptions& options, size_t index) {
  return fmt::format("{} entry {}", options.sweep, index);
}

// Holds a configuration of the sweep, and its row of the results.
struct Point {
  size_t index;
  lab::Configuration configuration;
  RenderOptions options;
  ChartRow row;
  size_t rounds_left;
  bool is_drawn = false;
};

class Chart {
 public:
  explicit Chart(const ChartOptions& options) : options_(options), folder_(options) {}
  int run();

 private:
  std::vector<Point> points(const std::vector<lab::Configuration>& sweep) const;
  std::vector<Point> default_points();
  void draw_reference(Progress& progress);
  void draw_picture(Point& point);
  void measure_round(Point& point);
  void wake(const Point& point);
  void measure(std::vector<Point>& points);
  // Returns the rows of all points if every one is measured.
  std::optional<std::vector<ChartRow>> gather(const std::vector<Point>& points) const;
  int measure_and_write(std::vector<Point>& points);

  ChartOptions options_;
  ChartFolder folder_;
  std::vector<std::string> notes_;  // about the list, printed if the chart succeeds
  std::optional<Session> session_;
  std::optional<ChartSequence> sequence_;  // only in a chart of a sequence
  lab::ChartReference reference_;
  std::optional<scenes::Image> reference_picture_;
};

std::vector<Point> Chart::points(const std::vector<lab::Configuration>& sweep) const {
  std::vector<Point> points;
  for (size_t i = 0; i < sweep.size(); ++i) {
    Point point{i, sweep[i], {}, {}, options_.repeats};
    point.options = resolve_row(options_, sweep[i], entry_name(options_, i), folder_.path(folder_.row_output(i)));
    point.row = {folder_.made_with(point.options), {}, {}, ChartFolder::image(i), {}};
    points.push_back(std::move(point));
  }
  return points;
}

// Returns the points of the list that fits the scene, without those that options for the whole chart make equal.
std::vector<Point> Chart::default_points() {
  const RenderOptions by_default = resolve_row(options_, {{"translucency", "hybrid"}}, "chart", folder_.row_output(0));
  const lab::DefaultSweep sweep = lab::default_sweep(*options_.built_in, sweep_scene(*session_, by_default));
  for (const std::string& reason : sweep.left_out) notes_.push_back("left out: " + reason);
  std::vector<Json> used;
  std::vector<lab::Configuration> distinct;
  for (const lab::Configuration& configuration : sweep.configurations) {
    // Compares the requested numbers of layers, since a plan changes them by the objects that have layers.
    Json config = used_config(resolve_row(options_, configuration, "chart", folder_.row_output(0)), {});
    if (std::find(used.begin(), used.end(), config) != used.end()) continue;
    used.push_back(std::move(config));
    distinct.push_back(configuration);
  }
  notes_.push_back(fmt::format("sweep {}: {} points", options_.sweep, distinct.size()));
  return points(distinct);
}

void Chart::draw_reference(Progress& progress) {
  if (sequence_) {
    reference_ = sequence_->draw_reference(progress);
    return;
  }
  progress.next("reference");
  std::optional<lab::ChartReference> kept;
  if (options_.resume || options_.shard.count > 1) kept = folder_.restore_reference();
  if (kept) {
    reference_ = *kept;
  } else {
    const RenderOptions options = resolve_reference(options_, folder_.path(folder_.reference_output()));
    const Session::Drawn drawn = session_->draw(options);
    write_picture(drawn.picture, drawn.light_names, options);
    const sideray_render_stats& stats = drawn.run.stats;
    reference_ = {folder_.reference_image(), stats.reference_light_samples, {}, stats.reference_bounces};
    reference_.caustics = stats.reference_caustics != 0;
    if (stats.reference_self_error >= 0) reference_.self_error = stats.reference_self_error;
    folder_.save_reference(reference_);
  }
  reference_picture_ = scenes::read_image(folder_.path(reference_.image));
}

// Compares the written file, so that `sideray compare` gives the same error.
void Chart::draw_picture(Point& point) {
  if (sequence_) {
    point.row.error = sequence_->draw(point.options, folder_.path(point.row.image));
  } else {
    const Session::Drawn drawn = session_->draw(point.options);
    write_picture(drawn.picture, drawn.light_names, point.options);
    const scenes::Image image = scenes::read_image(point.options.output);
    point.row.error = lab::to_json(lab::compare(image, *reference_picture_, point.options.display).metrics);
    point.row.stats = stats_json(point.options, drawn.run);
  }
  point.is_drawn = true;
  folder_.save_row(point.index, point.row);
}

void Chart::measure_round(Point& point) {
  if (sequence_) {
    point.row.add_round(sequence_->measure(point.options));
  } else {
    RenderOptions once = point.options;
    once.repeats = 1;
    point.row.add_round(stats_json(once, session_->draw(once).run));
  }
  folder_.save_row(point.index, point.row);
  --point.rounds_left;
}

// Draws for a while: comparing pictures leaves a GPU idle for seconds, after which it is slower at first.
void Chart::wake(const Point& point) {
  constexpr std::chrono::milliseconds enough(300);
  const RenderOptions picture =
      options_.frames ? frame_options(point.options, {options_.frames->first, true, false}) : point.options;
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < enough) (void)session_->draw(picture);
}

// Measures in rounds instead of one configuration after another, so that drift of the machine affects all alike.
void Chart::measure(std::vector<Point>& points) {
  std::vector<Point*> unmeasured;
  size_t steps = sequence_ ? sequence_->reference_steps() : 1;
  for (Point& point : points) {
    if (point.index % options_.shard.count != options_.shard.index) continue;
    if (options_.resume)
      if (std::optional<ChartRow> kept = folder_.restore_row(point.index, point.row.made_with)) {
        point.row = std::move(*kept);
        point.is_drawn = !point.row.error.is_null();
        point.rounds_left -= std::min(point.rounds_left, point.row.rounds());
      }
    if (point.rounds_left == 0) continue;
    unmeasured.push_back(&point);
    steps += point.rounds_left + (point.is_drawn ? 0 : 1);
  }
  Progress progress(steps);
  draw_reference(progress);
  for (Point* point : unmeasured) {
    if (point->is_drawn) continue;
    progress.next("picture: " + lab::describe(point->configuration));
    draw_picture(*point);
  }
  if (!unmeasured.empty()) wake(*unmeasured.front());
  for (uint32_t round = 0; round < options_.repeats; ++round)
    for (Point* point : unmeasured) {
      if (point->rounds_left == 0) continue;
      progress.next(fmt::format("round {}: {}", round + 1, lab::describe(point->configuration)));
      measure_round(*point);
    }
}

std::optional<std::vector<ChartRow>> Chart::gather(const std::vector<Point>& points) const {
  std::vector<ChartRow> rows;
  for (const Point& point : points) {
    if (point.index % options_.shard.count == options_.shard.index) {
      rows.push_back(point.row);
      continue;
    }
    std::optional<ChartRow> other = folder_.restore_row(point.index, point.row.made_with);
    if (!other || other->rounds() < options_.repeats) return {};
    rows.push_back(std::move(*other));
  }
  return rows;
}

int Chart::measure_and_write(std::vector<Point>& points) {
  folder_.prepare();
  if (options_.ledger) prepare_ledger(folder_);
  if (!options_.resume) {
    folder_.remove_rows_from(points.size());
    if (!options_.ledger) remove_ledger(folder_);
  }
  for (const std::string& note : notes_) fmt::print("{}\n", note);
  std::fflush(stdout);
  measure(points);
  const std::optional<std::vector<ChartRow>> rows = gather(points);
  if (!rows) {
    fmt::print("{}: rows of other shards are missing; the run that finds all writes the results\n", options_.folder);
    return exit_ok;
  }
  std::vector<PagePoint> shown;
  for (const Point& point : points) shown.push_back({lab::describe(point.configuration), &point.options});
  return write_chart(options_, folder_, reference_, shown, *rows,
                     options_.ledger ? ledger(options_, folder_, *session_, reference_) : Json());
}

int Chart::run() {
  std::vector<Point> all;
  // Checks a file before anything is loaded.
  if (!options_.built_in) {
    all = points(read_configurations(options_.sweep, "entry"));
    if (all.empty()) wrong_usage("{}: holds no configuration; write [{{\"option\": value, ...}}, ...]", options_.sweep);
  }
  const RenderOptions reference = resolve_reference(options_, folder_.path(folder_.reference_output()));
  session_.emplace(options_.frames ? frame_options(reference, {options_.frames->first}) : reference);
  if (options_.frames) sequence_.emplace(options_, folder_, *session_);
  if (options_.built_in) all = default_points();
  for (const Point& point : all) try {
      (void)session_->ray_traced(point.options);
    } catch (const UsageError& error) {
      wrong_usage("{}: {}", entry_name(options_, point.index), error.what());
    }
  if (!options_.shard.is_recorded()) return measure_and_write(all);
  std::vector<lab::Configuration> configurations;
  for (const Point& point : all) configurations.push_back(point.configuration);
  const RunRecord run = chart_run(options_, folder_, configurations);
  join_run(run);
  return run_task(run, options_.shard, [&] { return measure_and_write(all); });
}

}  // namespace

int chart(const std::string& scene, const Given& given) {
  return Chart(resolve_chart(scene, given)).run();
}

}  // namespace sideray::cli
