// Runs one of many tasks of a render that a scheduler has started. Main thread.
#pragma once

#include <functional>

#include "cli/render/run_pictures.h"

namespace sideray::cli {

// Creates the folder of the run, so that outputs can be checked, and lets every render resume, since tasks may be
// restarted. Throws UsageError for options that would let every task choose what it draws.
void prepare_run(std::vector<RenderOptions>& renders);

// Joins the run and draws this shard's part: `draw` gets the index of a render. Returns the first nonzero exit code.
int render_run(const std::vector<RenderOptions>& renders, const TaskShard& shard,
               const std::function<int(size_t index, const RunJob& job)>& draw);

}  // namespace sideray::cli
