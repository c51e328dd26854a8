// Checks whether the host's depth lies on traced surfaces, to find wrong matrices or depth conventions. Any thread may
// call it; it uses the scene's threads.
#pragma once

#include "rt/base/counters.h"
#include "rt/masks/mask_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Counts every second pixel of every second row that has an opaque surface, and those of them whose depth differs from
// that of any traced surface by more than a hundredth of the distance.
Counters check_surfaces(const MaskRequest& request, TracedScene& scene);

}  // namespace sideray::rt
