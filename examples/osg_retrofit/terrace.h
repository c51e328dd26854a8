// Makes the scene of the example engine: the terrace of the built-in bistro on a summer's day, and a van that passes
// behind the viewer. Any thread.
#pragma once

#include "scenes/content/content.h"

namespace sideray::retrofit {

// Returns the scene. Objects whose names begin with "van " and "lantern " are parts of these, relative to their
// origins.
scenes::Content make_terrace();

}  // namespace sideray::retrofit
