// The sets of values that `quality` names. Any thread.
#pragma once

#include "bridge/base/render_options.h"

namespace sideray::bridge {

enum class Quality { draft, balanced, best };

// Returns the preset's value of an option as static text, or null if it is the option's default. `before` holds the
// options that precede it in the table, on which the value may depend. The caller ignores it where the option is given.
const char* preset_value(Quality quality, const char* option, const RenderOptions& before);

}  // namespace sideray::bridge
