// What the tasks of one run have agreed on: DIR/shards/run.json, which the first of them writes and all others obey.
// Many machines may come at once; nothing is locked. Main thread.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/options/shard.h"

namespace sideray::cli {

using Json = nlohmann::ordered_json;

struct RunRecord {
  std::string folder;     // DIR
  std::string command;    // "render", "chart" or "stress"
  std::string scheduler;  // of the first task
  uint32_t shards = 1;
  Json work;  // what is made: all that a task must have in common with the others, by names of options
};

// Makes DIR and writes the record, unless another task did: then throws UsageError, naming what differs, where the run
// is not the same. Throws Error where the folder cannot be written.
void join_run(const RunRecord& run);

// Of a folder. Throws Error where it holds none.
RunRecord read_run(const std::string& folder);

// DIR/shards
std::string shards_folder(const std::string& folder);

}  // namespace sideray::cli
