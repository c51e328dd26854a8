#include <fmt/format.h>

#include "cli/base/failure.h"
#include "cli/gather/gather.h"
#include "cli/gather/survey.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

std::string described_parts(const Survey& run) {
  const size_t count = run.parts.size();
  if (run.run.command == "render") return fmt::format("{} pictures", count);
  if (run.run.command == "chart") return fmt::format("{} rows and their reference", count - 1);
  return fmt::format("{} cases", count);
}

size_t made(const Survey& run) {
  return run.parts.size() - run.missing().size();
}

Json tasks_json(const Survey& run) {
  Json tasks = Json::array();
  for (size_t shard = 0; shard < run.tasks.size(); ++shard) {
    if (!run.tasks[shard]) continue;
    const TaskNote& note = *run.tasks[shard];
    Json task = {{"shard", shard}, {"state", note.state}, {"node", note.node}};
    if (!note.error.empty()) task["error"] = note.error;
    tasks.push_back(std::move(task));
  }
  return tasks;
}

Json to_json(const Survey& run) {
  Json json = {{"schema", 1},
               {"command", run.run.command},
               {"scheduler", run.run.scheduler},
               {"shards", run.run.shards},
               {"total", run.parts.size()},
               {"done", made(run)},
               {"missing", run.missing()},
               {"running", run.missing("running")},
               {"failed", run.missing("failed")},
               {"tasks", tasks_json(run)},
               {"programs", Json::object()},
               {"mixed", run.programs().size() > 1},
               {"retry", retry_command(run)},
               {"retry_shards", run.to_run_again()}};
  for (const auto& [program, names] : run.programs()) json["programs"][program] = names.size();
  return json;
}

void print_tasks(const Survey& run) {
  for (size_t shard = 0; shard < run.tasks.size(); ++shard) {
    if (!run.tasks[shard] || run.tasks[shard]->state == "done") continue;
    const TaskNote& task = *run.tasks[shard];
    fmt::print("shard {}: {} on {}{}{}\n", shard, task.state, task.node, task.error.empty() ? "" : ": ", task.error);
  }
}

void print(const Survey& run) {
  fmt::print("{}: {} in {} shards, {}\n", run.run.folder, run.run.command, run.run.shards, described_parts(run));
  const size_t running = run.missing("running").size(), failed = run.missing("failed").size();
  fmt::print("done {}, running {}, missing {}, failed {}\n", made(run), running,
             run.missing().size() - running - failed, failed);
  print_tasks(run);
  if (!run.missing().empty()) fmt::print("missing: {}\n", listed(run.missing()));
  if (run.programs().size() > 1)
    for (const auto& [program, names] : run.programs()) fmt::print("program {}: {}\n", program, listed(names));
  if (!run.to_run_again().empty()) fmt::print("retry with --shard auto/{}: {}\n", run.run.shards, retry_command(run));
}

}  // namespace

int status(const std::string& folder, bool json) {
  const Survey run = survey(folder, false);
  if (json)
    fmt::print("{}\n", scenes::json_text(to_json(run), 2));
  else
    print(run);
  return run.is_whole() ? exit_ok : exit_failed;
}

}  // namespace sideray::cli
