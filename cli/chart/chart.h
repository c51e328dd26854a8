// `sideray chart`: measures speed and error of many configurations of a scene against one reference. Main thread.
#pragma once

#include "cli/options/options.h"

namespace sideray::cli {

// Measures, prints a table and returns the exit code. Throws UsageError or Error.
int chart(const std::string& scene, const Given& given);

}  // namespace sideray::cli
