// One task of a render that a scheduler has started many of. Main thread.
#pragma once

#include <functional>

#include "cli/render/run_pictures.h"

namespace sideray::cli {

// Makes the folder of the run, so that outputs can be checked, and lets every render resume: tasks are started again.
// Throws UsageError for options with which every task would decide for itself what it draws.
void prepare_run(std::vector<RenderOptions>& renders);

// Joins the run and draws what this shard has of it: `draw` gets the index of a render. Returns the first exit code
// that is not 0.
int render_run(const std::vector<RenderOptions>& renders, const TaskShard& shard,
               const std::function<int(size_t index, const RunJob& job)>& draw);

}  // namespace sideray::cli
