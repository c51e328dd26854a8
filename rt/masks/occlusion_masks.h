// Traces shadow and ambient occlusion masks of a frame's opaque pixels, by rays from the depth buffer, and filters them. One
// call at a time. Pixels: row 0 is the bottom row.
#pragma once

#include "rt/base/counters.h"
#include "rt/masks/mask_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Fills `masks`, except those that the request reuses; lights of the request that the scene does not have are an error.
// Throws Failure.
Counters trace_masks(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks);

}  // namespace sideray::rt
