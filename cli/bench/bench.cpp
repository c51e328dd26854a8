#include "cli/bench/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/render/frames.h"
#include "cli/session/picture_files.h"
#include "cli/session/session.h"
#include "lab/chart/chart_row.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

constexpr const char* to_standard_output = "-";

// Omits options that choose others or share a run: a benchmark measures the given options, alone.
Table bench_rows() {
  static const sideray_option rows[] = {
      text_row("o", "IMAGE", "", "writes the picture too"),
      number_row(text_row("repeat", "N", "5", "how often the picture is timed, after one untimed"), 1, 10000),
      text_row("json", "FILE|-", "", "writes what render --stats does, with all times; -: prints it instead")};
  Table t;
  for (const sideray_option& row : rows) t.push_back(&row);
  for (const sideray_option* row : picture_table(nullptr, [](const OwnOption& own) { return own.in_chart; }))
    t.push_back(row);
  return t;
}

struct BenchOptions {
  RenderOptions picture;
  bool writes_picture = false;
  std::string json;  // "" = none
};

BenchOptions resolve_bench(const std::string& scene, Given given) {
  check_given(bench_table(), given);
  if (scene.empty()) wrong_usage("bench: no scene; give a .gltf or .glb file or a built-in name (sideray make --list)");
  BenchOptions options;
  options.json = text_of(bench_table(), given, "json");
  options.writes_picture = given.contains("o");
  const uint32_t repeats = whole_number_of(bench_table(), given, "repeat");
  for (const char* own : {"json", "repeat"}) given.erase(own);
  if (!options.writes_picture) given["o"] = given.contains("frames") ? "bench.#.exr" : "bench.exr";  // never written
  options.picture = resolve_render(scene, given);
  options.picture.repeats = repeats;
  options.picture.raw_frame = !options.picture.frames;
  return options;
}

std::vector<RenderOptions> pictures_of(const RenderOptions& options) {
  if (!options.frames) return {options};
  std::vector<RenderOptions> pictures;
  for (uint32_t frame = options.frames->first; frame <= options.frames->last; ++frame)
    pictures.push_back(frame_options(options, {frame, true, frame > options.frames->first}));
  return pictures;
}

void check_bench_files(const BenchOptions& options) {
  const std::string json = options.json == to_standard_output ? "" : options.json;
  const std::string picture = options.writes_picture ? options.picture.output : "";
  if (!json.empty()) require_writable(json);
  if (picture.empty()) return;
  for (const RenderOptions& one : pictures_of(options.picture))
    require_distinct({{"-o", one.output}, {"--json", json}}, {});
  require_writable(pictures_of(options.picture).front().output);
}

RenderRun draw_timed(Session& session, const RenderOptions& picture, bool writes_picture) {
  session.move_to(picture);
  const Session::Drawn drawn = session.draw(picture);
  if (writes_picture) write_picture(drawn.picture, drawn.light_names, picture);
  return drawn.run;
}

// Returns the stages of one picture; for a sequence, quartiles over the medians of its frames.
std::vector<sideray_stage_time> stages_of(const std::vector<RenderRun>& runs) {
  std::vector<sideray_stage_time> stages = runs.front().stages;
  if (runs.size() == 1) return stages;
  for (size_t i = 0; i < stages.size(); ++i) {
    std::vector<double> medians;
    for (const RenderRun& run : runs) medians.push_back(run.stages[i].median);
    const lab::Quartiles ms = lab::quartiles(medians);
    stages[i].p25 = ms.p25, stages[i].median = ms.median, stages[i].p75 = ms.p75;
  }
  return stages;
}

void print_table(const std::vector<RenderRun>& runs) {
  const double raw_ms = runs.front().raw_frame.ms;
  fmt::print("{:12} {:>9} {:>9} {:>9}{}\n", "ms", "median", "p25", "p75", raw_ms > 0 ? " raw frames" : "");
  for (const sideray_stage_time& time : stages_of(runs)) {
    if (!(time.median > 0)) continue;
    fmt::print("{:12} {:9.2f} {:9.2f} {:9.2f}", time.name, time.median, time.p25, time.p75);
    if (raw_ms > 0 && (is_of_rays(time) || time.stage == SIDERAY_STAGE_TOTAL_FRAME))
      fmt::print(" {:10.2f}", time.median / raw_ms);
    fmt::print("\n");
  }
  if (raw_ms > 0) fmt::print("{:12} {:9.2f} {:>9} {:>9} {:10.2f}\n", "raw frame", raw_ms, "", "", 1.0);
}

// Returns a JSON object; for a sequence, a line for each frame.
std::string json_text(const BenchOptions& options, const std::vector<RenderOptions>& pictures,
                      const std::vector<RenderRun>& runs) {
  if (!options.picture.frames) return scenes::json_text(stats_json(pictures.front(), runs.front()), 2) + "\n";
  std::string text;
  for (size_t i = 0; i < runs.size(); ++i) {
    nlohmann::ordered_json line = {{"frame", options.picture.frames->first + i}};
    line.update(stats_json(pictures[i], runs[i]));
    text += scenes::json_text(line) + "\n";
  }
  return text;
}

}  // namespace

const Table& bench_table() {
  static const Table options = bench_rows();
  return options;
}

int bench(const std::string& scene, const Given& given) {
  const BenchOptions options = resolve_bench(scene, given);
  check_bench_files(options);
  const std::vector<RenderOptions> pictures = pictures_of(options.picture);
  // A framed camera stays where it is in the sequence's first frame.
  Session session(pictures.front());
  std::vector<RenderRun> runs;
  for (const RenderOptions& picture : pictures) runs.push_back(draw_timed(session, picture, options.writes_picture));
  if (options.json == to_standard_output) {
    fmt::print("{}", json_text(options, pictures, runs));
    return exit_ok;
  }
  print_table(runs);
  if (!options.json.empty()) write_text(options.json, json_text(options, pictures, runs));
  return exit_ok;
}

}  // namespace sideray::cli
