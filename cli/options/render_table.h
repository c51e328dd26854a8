// Lists the options of `sideray render` in the order of its help, and those of other commands that draw. Any thread.
#pragma once

#include "cli/options/own_options.h"

namespace sideray::cli {

// Returns the rows of the library and of the program that `keep` accepts; nullptr: all.
Table picture_table(bool (*keep_library)(const sideray_option&), bool (*keep_own)(const OwnOption&));

const Table& render_table();

}  // namespace sideray::cli
