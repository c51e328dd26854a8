// What is there of a run that many tasks share. Reads files alone: it needs neither scene nor OpenGL. Main thread.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "cli/record/run_part.h"
#include "cli/record/task_note.h"

namespace sideray::cli {

struct Survey {
  RunRecord run;
  std::vector<RunPart> parts;
  std::vector<std::optional<TaskNote>> tasks;  // of each shard, the last one

  // The programs that made parts, with the names of those.
  std::map<std::string, std::vector<Json>> programs() const;
  // Parts that are not there, those of tasks in a state where one is given.
  std::vector<Json> missing(const std::string& state = "") const;
  // Shards that have to run again: where parts are missing that no task is at work on, or made by another program than
  // most.
  std::vector<uint32_t> to_run_again() const;
  bool is_whole() const { return missing().empty() && programs().size() <= 1; }
};

// `reads_all`: also whether pictures have the bytes that were written. Throws Error where the folder holds no run.
Survey survey(const std::string& folder, bool reads_all);

// "frames 3, 12-49"; names that are no numbers one by one, and no more than a line holds.
std::string listed(const std::vector<Json>& names);

// How to have the scheduler run shards again: "sbatch --array=2,5-7".
std::string retry_command(const Survey& survey);

}  // namespace sideray::cli
