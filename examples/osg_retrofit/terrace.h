// What the example engine shows: the terrace of the built-in bistro on a summer's day, and a van that passes behind the
// viewer. Any thread.
#pragma once

#include "scenes/content/content.h"

namespace sideray::retrofit {

// The van's parts, and the lantern's, are the objects whose names begin with "van " and "lantern ", about their origin.
scenes::Content make_terrace();

}  // namespace sideray::retrofit
