// Shadow and ambient occlusion masks of a frame's opaque pixels, by rays from the depth buffer. Plain memory; any
// thread. Pixels: row 0 is the bottom row.
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/counters.h"
#include "rt/base/executor.h"
#include "rt/embree/intersector.h"
#include "rt/masks/mask_request.h"

namespace sideray::rt {

// Fills `masks`; lights of the mask that the snapshot does not have are an error. Throws Failure.
Counters trace_occlusion_masks(const MaskRequest& request, const model::Snapshot& snapshot,
                                    const Intersector& intersector, Executor& executor, OcclusionMasks& masks);

}  // namespace sideray::rt
