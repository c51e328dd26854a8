// `sideray bench`: draws a picture, or each of a sequence, as `render` does, and times it. Main thread.
#pragma once

#include "cli/options/options.h"

namespace sideray::cli {

const Table& bench_table();

// Prints a table of the stages, and writes --json. Returns the exit code. Throws UsageError or Error.
int bench(const std::string& scene, const Given& given);

}  // namespace sideray::cli
