// Describes the surface in the pixel under the mouse, and its values in the pictures. Main thread.
#pragma once

#include <string>

#include "viewer/interface/state.h"

namespace sideray::viewer {

// Returns several lines.
std::string inspection_text(const State& state, const Drawer::Shown& shown);

}  // namespace sideray::viewer
