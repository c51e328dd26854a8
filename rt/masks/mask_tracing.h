// Traces the masks of a frame's opaque pixels and filters them. One call at a time.
#pragma once

#include "rt/base/counters.h"
#include "rt/masks/mask_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Throws Failure.
Counters trace_masks(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks);

}  // namespace sideray::rt
