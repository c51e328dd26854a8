// Checks the options that a host gave as structs, by the rows of the table. Any thread.
#pragma once

#include "bridge/base/render_options.h"

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) and names the option. What a reference does not read is not checked with it.
void check_options(const RenderOptions& options);

}  // namespace sideray::bridge
