// What of a scene decides what there is to choose between. Main thread.
#pragma once

#include "cli/session/session.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

// Seen as `options` say, which draw by default. Makes the session's renderer.
lab::SweepScene sweep_scene(Session& session, const RenderOptions& options);

}  // namespace sideray::cli
