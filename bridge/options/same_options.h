// Says whether two pictures have equivalent options. Any thread.
#pragma once

#include "bridge/base/render_options.h"

namespace sideray::bridge {

// Returns whether both draw the same picture of the same scene and view, apart from random numbers. Whether a picture
// continues, and how often it is repeated for its times, is not compared.
bool draw_alike(const RenderOptions& a, const RenderOptions& b);

}  // namespace sideray::bridge
