// Makes surfaces of hits on the quads of sprites (rt/poses/particle_quads.h). Any thread may call it.
#pragma once

#include "model/snapshot.h"
#include "rt/surfaces/surface_point.h"

namespace sideray::rt {

// Does what surface_point() does, for an instance of quads. The ray must end at the nearest opaque surface, because
// sprites fade in front of it.
SurfacePoint sprite_point(const model::Snapshot& snapshot, const Hit& hit, const Ray& ray, Cone cone);

}  // namespace sideray::rt
