// Sweep and jobs files as options that were given. Any thread.
#pragma once

#include "cli/options/options.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

// `entry_name`: what errors call an element. Throws Error for a file that cannot be read, UsageError for its content.
std::vector<lab::Configuration> read_configurations(const std::string& path, const std::string& entry_name);

// The options of one entry: flags that are false are not given. Throws UsageError.
Given given_of(const lab::Configuration& configuration, const std::string& name);

}  // namespace sideray::cli
