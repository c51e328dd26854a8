// `sideray chart`: many configurations of one scene against one reference, speed and error. Main thread.
#pragma once

#include "cli/options/render_options.h"

namespace sideray::cli {

// The options of `render` that apply, and chart's own.
const std::vector<Option>& chart_table();

// Measures, prints a table and returns the exit code. Throws UsageError or Error.
int chart(const std::string& scene, const Given& given);

}  // namespace sideray::cli
