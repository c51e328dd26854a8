// Finds which of N shards a run draws, from the option or from the scheduler's variables. Any thread.
#pragma once

#include <string>

#include "cli/options/sequence_plan.h"

namespace sideray::cli {

struct TaskShard : Shard {
  std::string scheduler;  // "slurm", "kubernetes" or "gridengine"; "" if I/N was given

  // Returns whether a scheduler started the run: it records its progress, and tasks agree on N and options.
  bool is_recorded() const { return !scheduler.empty(); }
};

// Parses I/N, auto or auto/N. auto is (SLURM_ARRAY_TASK_ID - _MIN) / _STEP of _COUNT, or JOB_COMPLETION_INDEX of
// JOB_COMPLETION_COUNT; auto/N is SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX or SGE_TASK_ID - 1 of N, so that some tasks
// of an array can be run again as the same shards. Throws UsageError, also for variables that are missing or contradict
// each other.
TaskShard parse_shard(const std::string& text);

}  // namespace sideray::cli
