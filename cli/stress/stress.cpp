#include "cli/stress/stress.h"

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/progress.h"
#include "cli/options/own_options.h"
#include "lab/stress/stress_page.h"
#include "scenes/images/images.h"

namespace sideray::cli {
namespace {

using lab::StressCase;
using lab::StressRow;

std::vector<StressCase> chosen_cases(const std::vector<std::string>& names) {
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

int list_cases() {
  for (const StressCase& c : lab::stress_cases()) fmt::print("{:<16} {}\n", c.name, c.question);
  return exit_ok;
}

std::vector<StressRow> run_cases(const std::vector<StressCase>& cases, Renderer& renderer, bool quick) {
  lab::StressStage stage = lab::stress_stage(renderer, quick);
  Progress progress(cases.size());
  std::vector<StressRow> rows;
  for (const StressCase& c : cases) {
    progress.next(c.name);
    for (StressRow& row : c.run(stage)) rows.push_back(std::move(row));
  }
  return rows;
}

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

// One line a variant and measure of a case: how often it fails, and the row that fails by most.
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

}  // namespace

const Table& stress_table() {
  static const sideray_option rows[] = {text_row("o", "DIR", "", "the folder to write"),
                                        flag_row("quick", "runs fewer values on smaller pictures"),
                                        flag_row("list", "lists the cases")};
  static const Table table{&rows[0], &rows[1], &rows[2], &find_own("gl")->row, &find_own("device")->row,
                           &find_own("threads")->row};
  return table;
}

int stress(const std::vector<std::string>& names, const Given& given) {
  check_given(stress_table(), given);
  if (given.contains("list")) return list_cases();
  const std::vector<StressCase> cases = chosen_cases(names);
  const auto text = [&](const char* name) { return text_of(stress_table(), given, name); };
  const std::string folder = text("o"), gl = text("gl"), device = text("device");
  if (folder.empty()) wrong_usage("stress: no output; give -o DIR");
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = gl.c_str();
  if (!device.empty()) desc.device = device.c_str();
  if (given.contains("threads")) desc.threads = whole_number_of(stress_table(), given, "threads");
  make_folder((std::filesystem::path(folder) / "maps").string());
  for (const char* name : {"results.json", "index.html"})
    require_writable((std::filesystem::path(folder) / name).string());
  Renderer renderer = Renderer::create(desc).value();
  const sideray_device_info info = renderer.device();
  const std::vector<StressRow> rows = run_cases(cases, renderer, given.contains("quick"));
  write(folder, cases, rows, fmt::format("{}, OpenGL {}", info.renderer, info.version));
  print_table(cases, rows);
  const size_t failed = lab::failing_defaults(rows).size();
  if (failed == 0) return exit_ok;
  print_error(fmt::format("stress: {} rows of defaults fail their bounds; see {}/index.html", failed, folder));
  return exit_failed;
}

}  // namespace sideray::cli
