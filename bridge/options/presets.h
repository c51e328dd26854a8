// The sets of values that `quality` names. Any thread.
#pragma once

#include <sideray/renderer.h>

namespace sideray::bridge {

enum class Quality { draft, balanced, best };

// Returns what the set has for an option where translucent surfaces are drawn by `method`, static text; null where that is
// the option's default. Each value counts only where the option is not given.
const char* preset_value(Quality quality, const char* option, sideray_translucency method);

}  // namespace sideray::bridge
