// The options of `sideray render`, in the order in which its help lists them. Any thread.
#pragma once

#include <vector>

#include "cli/options/options.h"

namespace sideray::cli {

const std::vector<Option>& render_table();

}  // namespace sideray::cli
