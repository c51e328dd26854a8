// `sideray chart`: many configurations of one scene against one reference, speed and error. Main thread.
#pragma once

#include "cli/options/options.h"

namespace sideray::cli {

// Measures, prints a table and returns the exit code. Throws UsageError or Error.
int chart(const std::string& scene, const Given& given);

}  // namespace sideray::cli
