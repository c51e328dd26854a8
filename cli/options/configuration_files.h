// Reads sweep and jobs files into options. Any thread.
#pragma once

#include "cli/options/options.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

// `entry_name`: names an element in errors. Throws Error for a file that cannot be read, UsageError for its content.
std::vector<lab::Configuration> read_configurations(const std::string& path, const std::string& entry_name);

// Returns the options of one entry, without flags that are false. Throws UsageError.
Given given_of(const lab::Configuration& configuration, const std::string& name);

}  // namespace sideray::cli
