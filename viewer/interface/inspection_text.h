// What lies behind the pixel under the mouse, and what the pictures show there. Main thread.
#pragma once

#include <string>

#include "viewer/interface/state.h"

namespace sideray::viewer {

// Some lines.
std::string inspection_text(const State& state, const Drawer::Shown& shown);

}  // namespace sideray::viewer
