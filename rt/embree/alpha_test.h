// Whether a surface is absent where a ray meets it, by its alpha. Any thread.
#pragma once

#include "model/snapshot.h"
#include "rt/base/ray.h"
#include "rt/embree/trace_table.h"

namespace sideray::rt {

// Whether a hit has too little alpha to be there: below the cut-off (MASK) or 1/255 (BLEND), textured at the level that
// the footprint of `cone` asks for, as the rasterizer's texture unit would.
bool alpha_discards(const model::Snapshot& snapshot, const TraceInstance& instance, const Ray& ray, const Hit& hit,
                    Cone cone);

}  // namespace sideray::rt
