// Traces shadow and ambient occlusion masks of a frame's opaque pixels, by rays from the depth buffer, and filters
// them. One call at a time. Row 0 of pixels is the bottom row.
#pragma once

#include "rt/base/counters.h"
#include "rt/masks/mask_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Fills `masks`, except those that the request reuses. Throws Failure, also if the scene lacks a light of the request.
Counters trace_masks(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks);

}  // namespace sideray::rt
