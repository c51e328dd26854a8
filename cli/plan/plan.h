// `sideray plan`: says what `render` would do with the same options, without drawing. Main thread.
#pragma once

#include <string>

#include "cli/options/options.h"

namespace sideray::cli {

const Table& plan_table();

// Prints the plan and returns the exit code. Throws UsageError or Error.
int plan(const std::string& scene, const Given& given);

}  // namespace sideray::cli
