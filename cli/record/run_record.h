// Records what the tasks of one run have in common: DIR/shards/run.json, which the first task writes and all others
// follow. Many machines may come at once; nothing is locked. Main thread.
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
  Json work;  // what is made: everything that tasks must have in common, by names of options
};

// Creates DIR and writes the record. If another task did, throws UsageError that names a difference of the two runs.
// Throws Error where the folder cannot be written.
void join_run(const RunRecord& run);

// Reads the record of a folder. Throws Error where there is none.
RunRecord read_run(const std::string& folder);

// Returns DIR/shards.
std::string shards_folder(const std::string& folder);

}  // namespace sideray::cli
