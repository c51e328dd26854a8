// Surveys a run that many tasks share. Only reads files: needs neither scene nor OpenGL. Main thread.
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
  std::vector<std::optional<TaskNote>> tasks;  // the last one of each shard

  // Returns the programs that made parts, each with the names of its parts.
  std::map<std::string, std::vector<Json>> programs() const;
  // Returns the parts that are missing; with `state`, only those of tasks in that state.
  std::vector<Json> missing(const std::string& state = "") const;
  // Returns shards to run again: those with parts that are missing or made by another program than most, unless a task
  // is running.
  std::vector<uint32_t> to_run_again() const;
  bool is_whole() const { return missing().empty() && programs().size() <= 1; }
};

// `reads_all`: also checks that pictures have the bytes that were written. Throws Error where the folder holds no run.
Survey survey(const std::string& folder, bool reads_all);

// Returns "frames 3, 12-49"; other names one by one, at most as many as fit a line.
std::string listed(const std::vector<Json>& names);

// Returns the scheduler's command to run shards again: "sbatch --array=2,5-7".
std::string retry_command(const Survey& survey);

}  // namespace sideray::cli
