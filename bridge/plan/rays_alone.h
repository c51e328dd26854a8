// Refuses options that rays alone cannot draw. Any thread.
#pragma once

#include "bridge/base/render_options.h"

namespace sideray::bridge {

// Throws Failure (UNSUPPORTED) that names the option which needs OpenGL, and the remedy.
void check_rays_alone(const RenderOptions& options);

}  // namespace sideray::bridge
