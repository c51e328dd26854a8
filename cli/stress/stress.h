// `sideray stress`: sweeps to where methods fail, against closed forms; writes tables, maps and a page. Main thread.
#pragma once

#include "cli/options/options.h"

namespace sideray::cli {

const Table& stress_table();

// Runs the named cases, or all, and returns the exit code: 1 where a default fails its bound. Throws UsageError or
// Error.
int stress(const std::vector<std::string>& names, const Given& given);

}  // namespace sideray::cli
