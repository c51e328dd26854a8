// Turns hits on the quads of sprites (rt/poses/particle_quads.h) into surfaces. Any thread may call it.
#pragma once

#include "model/snapshot.h"
#include "rt/surfaces/surface_point.h"

namespace sideray::rt {

// Does what surface_point() does, for an instance of quads. The ray ends at the nearest opaque surface: sprites fade
// before it.
SurfacePoint sprite_point(const model::Snapshot& snapshot, const Hit& hit, const Ray& ray, Cone cone);

}  // namespace sideray::rt
