#include "cli/stress/stress_run.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/ranges.h>
#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/program.h"
#include "lab/stress/stress_page.h"
#include "lab/stress/stress_rows.h"
#include "scenes/base/files.h"
#include "scenes/images/images.h"

namespace sideray::cli {
namespace {

using lab::StressCase;
using lab::StressRow;

void write(const std::string& folder, const std::vector<StressCase>& cases, const std::vector<StressRow>& rows,
           const std::string& device) {
  const auto path = [&](const std::string& name) { return (std::filesystem::path(folder) / name).string(); };
  for (const StressCase& c : cases) {
    const lab::Sheet sheet = lab::failure_sheet(lab::rows_of(c.name, rows));
    if (sheet.width > 0) scenes::write_png(path("maps/" + c.name + ".png"), sheet.width, sheet.height, sheet.rgb);
  }
  write_text(path("results.json"), lab::stress_json(rows).dump(2) + "\n");
  write_text(path("index.html"), lab::stress_page(cases, rows, device));
}

// Prints a line for each variant and measure of a case: how often it fails, and the row that fails by most.
void print_table(const std::vector<StressCase>& cases, const std::vector<StressRow>& rows) {
  fmt::print("{:<16} {:>9}  {:<52} {}\n", "case", "fails", "variant (* default)", "measure: worst value");
  for (const StressCase& c : cases) {
    const std::span<const StressRow> of_case = lab::rows_of(c.name, rows);
    std::vector<std::pair<std::string, std::string>> seen;
    for (const StressRow& first : of_case) {
      const std::pair key{first.variant, first.measure};
      if (std::ranges::find(seen, key) != seen.end()) continue;
      seen.push_back(key);
      size_t count = 0, failed = 0;
      const StressRow* worst = &first;
      for (const StressRow& row : of_case) {
        if (std::pair{row.variant, row.measure} != key) continue;
        ++count, failed += !row.pass();
        if (row.value - row.bound > worst->value - worst->bound) worst = &row;
      }
      fmt::print("{:<16} {:>9}  {:<52} {}: {:.3g} at {}\n", c.name, fmt::format("{} of {}", failed, count),
                 (first.is_default ? "* " : "  ") + first.variant, first.measure, worst->value,
                 lab::describe_parameters(*worst, of_case));
    }
  }
}

int write_files(const std::string& folder, const std::vector<StressCase>& cases, const std::vector<CaseFile>& files) {
  std::vector<StressRow> rows;
  std::set<std::string> devices;
  for (const CaseFile& file : files) {
    rows.insert(rows.end(), file.rows.begin(), file.rows.end());
    devices.insert(file.device);
  }
  return write_stress(folder, cases, rows, fmt::format("{}", fmt::join(devices, "; ")));
}

bool is_quick(const RunRecord& run) {
  return run.work.at("options").contains("quick");
}

}  // namespace

std::vector<StressCase> stress_cases_named(const std::vector<std::string>& names) {
  const std::vector<StressCase>& all = lab::stress_cases();
  const auto named = [](const StressCase& c) { return c.name; };
  for (const std::string& name : names)
    if (std::ranges::find(all, name, named) == all.end())
      wrong_usage("stress: no case \"{}\"; see sideray stress --list", name);
  std::vector<StressCase> chosen;
  for (const StressCase& c : all)
    if (names.empty() || std::ranges::find(names, c.name) != names.end()) chosen.push_back(c);
  return chosen;
}

std::string case_file(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / "rows" / (name + ".json")).string();
}

void save_case(const std::string& folder, const std::string& name, bool quick, const CaseFile& content) {
  const Json json = {{"schema", 1},
                     {"program", content.program},
                     {"quick", quick},
                     {"device", content.device},
                     {"rows", lab::rows_json(content.rows)}};
  write_text(case_file(folder, name), json.dump(1) + "\n");
}

std::optional<CaseFile> restore_case(const std::string& folder, const std::string& name, bool quick) {
  constexpr uint64_t most_bytes = uint64_t{256} << 20;
  std::error_code ignored;
  const std::string path = case_file(folder, name);
  if (!std::filesystem::is_regular_file(path, ignored)) return {};
  const Json json = Json::parse(scenes::read_file(path, most_bytes), nullptr, false);
  if (!json.is_object() || json.value("quick", !quick) != quick || !json.contains("rows")) return {};
  std::optional<std::vector<StressRow>> rows = lab::parse_rows(json["rows"]);
  if (!rows) return {};
  return CaseFile{json.value("program", ""), json.value("device", ""), std::move(*rows)};
}

int write_stress(const std::string& folder, const std::vector<StressCase>& cases, const std::vector<StressRow>& rows,
                 const std::string& device) {
  write(folder, cases, rows, device);
  print_table(cases, rows);
  const size_t failed = lab::failing_defaults(rows).size();
  if (failed == 0) return exit_ok;
  print_error(fmt::format("stress: {} rows of defaults fail their bounds; see {}/index.html", failed, folder));
  return exit_failed;
}

RunRecord stress_run(const std::string& folder, const TaskShard& shard, const std::vector<StressCase>& cases,
                     const Given& given) {
  RunRecord run{
      folder, "stress", shard.scheduler, shard.count, {{"options", Json::object()}, {"cases", Json::array()}}};
  for (const auto& [name, text] : given)
    if (name != "o" && name != "shard" && name != "threads") run.work["options"][name] = text;
  for (const StressCase& c : cases) run.work["cases"].push_back(c.name);
  return run;
}

std::vector<RunPart> stress_parts(const RunRecord& run) {
  std::vector<RunPart> parts;
  for (const std::string name : run.work.at("cases")) {
    RunPart part{name, static_cast<uint32_t>(parts.size() % run.shards), case_file(run.folder, name), "", ""};
    if (const std::optional<CaseFile> file = restore_case(run.folder, name, is_quick(run))) {
      part.program = file->program;
      part.device = file->device;
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

int gather_stress(const RunRecord& run) {
  const auto cases = stress_cases_named(run.work.at("cases").get<std::vector<std::string>>());
  std::vector<CaseFile> files;
  for (const StressCase& c : cases) {
    std::optional<CaseFile> file = restore_case(run.folder, c.name, is_quick(run));
    if (!file)
      scenes::refuse("{}: case {} cannot be read any more; see that nothing else changes the folder, and gather again",
                     run.folder, c.name);
    files.push_back(std::move(*file));
  }
  return write_files(run.folder, cases, files);
}

std::optional<int> gather_cases(const std::string& folder, const std::vector<StressCase>& cases, bool quick) {
  std::vector<CaseFile> files;
  for (const StressCase& c : cases) {
    std::optional<CaseFile> file = restore_case(folder, c.name, quick);
    if (!file || file->program != program_build()) return {};
    files.push_back(std::move(*file));
  }
  return write_files(folder, cases, files);
}

}  // namespace sideray::cli
