// Decides by its alpha whether a surface is absent where a ray hits it. Any thread may call it.
#pragma once

#include "model/snapshot.h"
#include "rt/base/ray.h"
#include "rt/embree/trace_table.h"

namespace sideray::rt {

// Returns whether a hit has too little alpha to be there: below the cut-off (MASK) or 1/255 (BLEND), textured at the
// level that the footprint of `cone` requires, as the rasterizer's texture unit would do it.
bool alpha_discards(const model::Snapshot& snapshot, const TraceInstance& instance, const Ray& ray, const Hit& hit,
                    Cone cone);

}  // namespace sideray::rt
