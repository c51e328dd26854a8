// Collects the facts of a scene that decide which configurations to choose between. Main thread.
#pragma once

#include "cli/session/session.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

// Uses the view of `options` and the layers that objects have by default. Creates the session's renderer.
lab::SweepScene sweep_scene(Session& session, RenderOptions options);

}  // namespace sideray::cli
