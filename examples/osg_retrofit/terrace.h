// Makes the scene of the example engine: the terrace of the built-in bistro on a summer's day, and a van that passes
// behind the viewer. Any thread.
#pragma once

#include "scenes/content/content.h"

namespace sideray::retrofit {

// The parts of the van and of the lantern are the objects whose names begin with "van " and "lantern ", placed relative
// to their origin.
scenes::Content make_terrace();

}  // namespace sideray::retrofit
