// What a task of a run says of itself while it works: DIR/shards/0002.json, rewritten at its beginning and end, and
// touched every few seconds in between. It locks nothing: two tasks of one shard draw the same. Main thread.
#pragma once

#include <functional>
#include <optional>

#include "cli/record/run_record.h"

namespace sideray::cli {

// Does the work of a shard and says so; returns what it returns, and throws what it throws.
int run_task(const RunRecord& run, Shard shard, const std::function<int()>& work);

struct TaskNote {
  std::string state;  // "running", "done", "failed"; "lost": it said that it runs and gives no sign of life
  std::string node;   // where it ran
  std::string error;  // why it failed
};

// Of the last task of a shard; empty where none came.
std::optional<TaskNote> read_task(const std::string& folder, uint32_t shard);

// The machine as the scheduler calls it.
std::string node_name();

}  // namespace sideray::cli
