// Records the state of a task of a run: DIR/shards/0002.json, written at its start and end, and touched every few
// seconds meanwhile. It locks nothing: two tasks of one shard draw the same. Main thread.
#pragma once

#include <functional>
#include <optional>

#include "cli/record/run_record.h"

namespace sideray::cli {

// Does the work of a shard and records its state; returns or throws what the work does.
int run_task(const RunRecord& run, Shard shard, const std::function<int()>& work);

struct TaskNote {
  std::string state;  // "running", "done", "failed"; "lost": running, but not touched any more
  std::string node;   // where it ran
  std::string error;  // why it failed
};

// Reads the note of the last task of a shard; empty where there was none.
std::optional<TaskNote> read_task(const std::string& folder, uint32_t shard);

// Returns the scheduler's name for this machine.
std::string node_name();

}  // namespace sideray::cli
