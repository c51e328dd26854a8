// The sets of values that `quality` names. Any thread.
#pragma once

#include "bridge/base/render_options.h"

namespace sideray::bridge {

enum class Quality { draft, balanced, best };

// Returns what the set has for an option beside the values of options before it, static text; null where that is the option's
// default. Each value counts only where the option is not given.
const char* preset_value(Quality quality, const char* option, const RenderOptions& before);

}  // namespace sideray::bridge
