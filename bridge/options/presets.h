// Defines the sets of values that `quality` names. Any thread.
#pragma once

#include "bridge/base/render_options.h"

namespace sideray::bridge {

enum class Quality { draft, balanced, best };

// Returns the preset's value of an option as static text, or null where it is the option's default. `before` holds the
// options before it in the table, which the value may depend on. The caller ignores it for options that are set.
const char* preset_value(Quality quality, const char* option, const RenderOptions& before);

}  // namespace sideray::bridge
