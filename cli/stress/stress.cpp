#include "cli/stress/stress.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/program.h"
#include "cli/base/progress.h"
#include "cli/options/own_options.h"
#include "cli/record/task_note.h"
#include "cli/stress/stress_run.h"
#include "lab/stress/stress_page.h"

namespace sideray::cli {
namespace {

using lab::StressCase;
using lab::StressRow;

int list_cases() {
  for (const StressCase& c : lab::stress_cases()) fmt::print("{:<16} {}\n", c.name, c.question);
  return exit_ok;
}

// Holds the options of a run of cases.
struct StressOptions {
  Given given;
  std::string folder;
  std::vector<StressCase> cases;
  bool quick = false;
  uint32_t threads = 0;  // 0: all
  std::optional<TaskShard> shard;
};

StressOptions resolve_stress(const std::vector<std::string>& names, const Given& given) {
  StressOptions options;
  options.given = given;
  options.folder = text_of(stress_table(), given, "o");
  options.cases = stress_cases_named(names);
  if (options.folder.empty()) wrong_usage("stress: no output; give -o DIR");
  options.quick = given.contains("quick");
  if (given.contains("threads")) options.threads = whole_number_of(stress_table(), given, "threads");
  if (given.contains("shard")) options.shard = parse_shard(given.at("shard"));
  return options;
}

void prepare(const StressOptions& options) {
  const std::filesystem::path folder(options.folder);
  for (const char* part : {"maps", "rows"})
    if (part != std::string("rows") || options.shard) make_folder((folder / part).string());
  for (const char* name : {"results.json", "index.html"}) require_writable((folder / name).string());
}

Renderer make_renderer(const StressOptions& options) {
  const auto text = [&](const char* name) { return text_of(stress_table(), options.given, name); };
  const std::string gl = text("gl"), device = text("device");
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = gl.c_str();
  if (!device.empty()) desc.device = device.c_str();
  desc.threads = options.threads;
  return Renderer::create(desc).value();
}

std::string device_of(const Renderer& renderer) {
  const sideray_device_info info = renderer.device();
  return *info.version ? fmt::format("{}, OpenGL {}", info.renderer, info.version) : std::string(info.renderer);
}

// Says which cases have no rows because nothing draws the fragments that they test.
void tell_left_out(const std::vector<StressCase>& cases, const lab::StressStage& stage) {
  std::vector<std::string> names;
  for (const StressCase& c : cases)
    if (!lab::has_meaning(c, stage)) names.push_back(c.name);
  if (names.empty()) return;
  print_warning(fmt::format("stress: without OpenGL no fragment looks for layers: {} left out", fmt::join(names, ", ")));
}

int run_whole(const StressOptions& options) {
  Renderer renderer = make_renderer(options);
  lab::StressStage stage = lab::stress_stage(renderer, options.quick);
  tell_left_out(options.cases, stage);
  Progress progress(options.cases.size());
  std::vector<StressRow> rows;
  for (const StressCase& c : options.cases) {
    progress.next(c.name);
    for (StressRow& row : lab::run_case(c, stage)) rows.push_back(std::move(row));
  }
  return write_stress(options.folder, options.cases, rows, device_of(renderer));
}

// Returns the cases of the shard; in a run of many tasks, only missing ones.
std::vector<StressCase> cases_to_run(const StressOptions& options) {
  std::vector<StressCase> cases;
  for (size_t i = 0; i < options.cases.size(); ++i) {
    if (i % options.shard->count != options.shard->index) continue;
    const std::optional<CaseFile> made = restore_case(options.folder, options.cases[i].name, options.quick);
    const bool is_kept = options.shard->is_recorded() && made && made->program == program_build();
    if (!is_kept) cases.push_back(options.cases[i]);
  }
  return cases;
}

int run_shard(const StressOptions& options) {
  const std::vector<StressCase> cases = cases_to_run(options);
  std::vector<StressRow> rows;
  if (!cases.empty()) {
    Renderer renderer = make_renderer(options);
    lab::StressStage stage = lab::stress_stage(renderer, options.quick);
    tell_left_out(cases, stage);
    Progress progress(cases.size());
    for (const StressCase& c : cases) {
      progress.next(c.name);
      const CaseFile made{program_build(), device_of(renderer), lab::run_case(c, stage)};
      save_case(options.folder, c.name, options.quick, made);
      rows.insert(rows.end(), made.rows.begin(), made.rows.end());
    }
  }
  if (const std::optional<int> code = gather_cases(options.folder, options.cases, options.quick)) return *code;
  fmt::print("{}: rows of other shards are missing; the run that finds all writes the results\n", options.folder);
  return lab::failing_defaults(rows).empty() ? exit_ok : exit_failed;
}

}  // namespace

const Table& stress_table() {
  static const sideray_option rows[] = {
      text_row("o", "DIR", "", "the folder to write"), flag_row("quick", "runs fewer values on smaller pictures"),
      text_row("shard", "I/N|auto[/N]", "", "only the cases whose index modulo N is I; auto: as the scheduler says"),
      flag_row("list", "lists the cases")};
  static const Table table{&rows[0],
                           &rows[1],
                           &rows[2],
                           &rows[3],
                           &find_own("gl")->row,
                           &find_own("device")->row,
                           &find_own("threads")->row};
  return table;
}

int stress(const std::vector<std::string>& names, const Given& given) {
  check_given(stress_table(), given);
  if (given.contains("list")) return list_cases();
  const StressOptions options = resolve_stress(names, given);
  prepare(options);
  if (!options.shard) return run_whole(options);
  if (!options.shard->is_recorded()) return run_shard(options);
  const RunRecord run = stress_run(options.folder, *options.shard, options.cases, given);
  join_run(run);
  return run_task(run, *options.shard, [&] { return run_shard(options); });
}

}  // namespace sideray::cli
