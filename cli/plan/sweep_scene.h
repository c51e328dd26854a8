// Says what of a scene decides which configurations there are to choose between. Main thread.
#pragma once

#include "cli/session/session.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

// The scene with the view of `options` and the layers that its objects have by default. Makes the session's renderer.
lab::SweepScene sweep_scene(Session& session, RenderOptions options);

}  // namespace sideray::cli
