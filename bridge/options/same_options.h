// Says whether two pictures are asked for alike. Any thread.
#pragma once

#include "bridge/base/render_options.h"

namespace sideray::bridge {

// Returns whether both draw the same picture of the same scene and view, apart from its random numbers. Whether a
// picture follows the last one, and how often it is drawn again for its times, is not compared.
bool draw_alike(const RenderOptions& a, const RenderOptions& b);

}  // namespace sideray::bridge
