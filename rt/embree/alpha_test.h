// Tests the alpha of a surface where a ray hits it. Any thread may call it.
#pragma once

#include "model/snapshot.h"
#include "rt/base/ray.h"
#include "rt/embree/trace_table.h"

namespace sideray::rt {

// Returns whether the hit's alpha is below the cut-off (MASK) or 1/255 (BLEND), so that the ray passes. The texture is
// sampled at the mip level of the footprint of `cone`, as the rasterizer's texture unit does.
bool alpha_discards(const model::Snapshot& snapshot, const TraceInstance& instance, const Ray& ray, const Hit& hit,
                    const AlphaCone& cone);

}  // namespace sideray::rt
