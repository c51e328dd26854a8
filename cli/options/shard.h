// Which of N shards a run does: as the option says, or as the scheduler says that started it. Any thread.
#pragma once

#include <string>

#include "cli/options/sequence_plan.h"

namespace sideray::cli {

struct TaskShard : Shard {
  std::string scheduler;  // "slurm", "kubernetes" or "gridengine"; "" where I/N was given

  // What a scheduler starts agrees with the other tasks on N and the options, and leaves word of what it does.
  bool is_recorded() const { return !scheduler.empty(); }
};

// Of I/N, auto or auto/N. auto is (SLURM_ARRAY_TASK_ID - _MIN) / _STEP of _COUNT, or JOB_COMPLETION_INDEX of
// JOB_COMPLETION_COUNT; auto/N is SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX or SGE_TASK_ID - 1 of N, so that a few
// tasks of an array that are run again are those they were. Throws UsageError, also for variables that are missing or
// contradict each other.
TaskShard parse_shard(const std::string& text);

}  // namespace sideray::cli
