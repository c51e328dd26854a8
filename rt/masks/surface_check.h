// Finds whether what a host has drawn lies on surfaces that are traced: for hosts whose matrices or depth conventions are
// wrong. Any thread may call it; it runs on the scene's.
#pragma once

#include "rt/base/counters.h"
#include "rt/masks/mask_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Counts, of every second pixel of every second row, those with an opaque surface, and those of them whose depth is not
// within a hundredth of its distance of a traced one.
Counters check_surfaces(const MaskRequest& request, TracedScene& scene);

}  // namespace sideray::rt
