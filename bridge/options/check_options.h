// Checks options that a host gave as structs, by the rows of the table. Any thread.
#pragma once

#include "bridge/base/render_options.h"

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) that names the option. Does not check options that a reference does not read.
void check_options(const RenderOptions& options);

}  // namespace sideray::bridge
