// `sideray view`: checks the options, and becomes the window, which is a program of its own.
#pragma once

#include "cli/options/options.h"

namespace sideray::cli {

const Table& view_table();

// Returns only if there is no window: throws UsageError.
int view(const std::string& scene, const Given& given);

}  // namespace sideray::cli
