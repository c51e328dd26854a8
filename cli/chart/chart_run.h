// Supports a chart whose rows many tasks measure: its record, which rows exist, and its page, without the scene or
// OpenGL. Main thread.
#pragma once

#include <span>

#include "cli/chart/chart_folder.h"
#include "cli/record/run_part.h"

namespace sideray::cli {

RunRecord chart_run(const ChartOptions& options, const ChartFolder& folder,
                    std::span<const lab::Configuration> configurations);

// Returns the rows and the reference.
std::vector<RunPart> chart_parts(const RunRecord& run);

// Writes results and page of a run that is complete and of one program; returns the exit code. Throws Error.
int gather_chart(const RunRecord& run, const std::string& program);

}  // namespace sideray::cli
