// The surfaces that sprites are where rays meet their quads (rt/poses/particle_quads.h). Any thread.
#pragma once

#include "model/snapshot.h"
#include "rt/surfaces/surface_point.h"

namespace sideray::rt {

// surface_point() on an instance of quads. The ray ends at what is opaque: sprites fade before it.
SurfacePoint sprite_point(const model::Snapshot& snapshot, const Hit& hit, const Ray& ray, Cone cone);

}  // namespace sideray::rt
