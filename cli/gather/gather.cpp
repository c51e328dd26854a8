#include "cli/gather/gather.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/chart/chart_run.h"
#include "cli/gather/survey.h"
#include "cli/render/run_pictures.h"
#include "cli/stress/stress_run.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

std::string what_to_do(const Survey& run) {
  if (run.to_run_again().empty()) return "wait for the tasks that run";
  return fmt::format("run with --shard auto/{}: {}", run.run.shards, retry_command(run));
}

void print_missing(const Survey& run) {
  print_error(fmt::format("{}: {} of {} are missing or not whole: {}; {}", run.run.folder, run.missing().size(),
                          run.parts.size(), listed(run.missing()), what_to_do(run)));
}

void print_mixture(const Survey& run) {
  std::vector<std::string> made;
  for (const auto& [program, names] : run.programs()) made.push_back(fmt::format("{} by {}", listed(names), program));
  print_error(fmt::format("{}: made by different programs: {}; with the one that made most of them, {}", run.run.folder,
                          fmt::join(made, ", "), what_to_do(run)));
}

// Warns of several drivers: they round differently, which is no error, but should be known.
void warn_of_devices(const Survey& run) {
  std::set<std::string> devices;
  for (const RunPart& part : run.parts)
    if (!part.device.empty()) devices.insert(part.device);
  if (devices.size() > 1)
    print_warning(fmt::format("{}: drawn on different devices, whose bits may differ: {}", run.run.folder,
                              fmt::join(devices, "; ")));
}

void remove_unfinished(const fs::path& folder, const std::function<bool(const std::string& name)>& is_ours) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const fs::path& file = entry.path();
    if (is_unfinished(file.filename().string()) && is_ours(file.stem().string())) fs::remove(file, ignored);
  }
}

// Removes what killed tasks were writing. The run has ended, but files of others may be beside its own.
void remove_unfinished(const Survey& run) {
  const fs::path folder(run.run.folder);
  std::set<fs::path> folders{folder};
  std::set<std::string> names{"results.json", "results.csv", "index.html"};
  for (const RunPart& part : run.parts) {
    const fs::path file(part.file);
    folders.insert(file.parent_path());
    names.insert({file.filename().string(), file.filename().string() + ".json"});
  }
  for (const fs::path& shared : folders)
    remove_unfinished(shared, [&](const std::string& name) { return names.contains(name); });
  for (const char* own : {"shards", "rows", "images", "maps"})
    if (run.run.command != "render" || own == std::string("shards"))
      remove_unfinished(folder / own, [](const std::string&) { return true; });
}

// Writes what is made of all parts. Tasks have reported faults in the rows that they measured; these do not make the
// set incomplete.
void write_whole(const Survey& run) {
  if (run.run.command == "render") gather_stats(run.run);
  if (run.run.command == "chart") (void)gather_chart(run.run, run.programs().begin()->first);
  if (run.run.command == "stress") (void)gather_stress(run.run);
}

}  // namespace

int gather(const std::string& folder) {
  const Survey run = survey(folder, true);
  if (!run.missing().empty())
    print_missing(run);
  else if (run.programs().size() > 1)
    print_mixture(run);
  if (!run.is_whole()) return exit_failed;
  warn_of_devices(run);
  write_whole(run);
  remove_unfinished(run);
  fmt::print("{}: whole, {} of {}\n", folder, run.parts.size(), run.programs().begin()->first);
  return exit_ok;
}

}  // namespace sideray::cli
