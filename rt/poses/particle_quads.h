// Sprites as rays meet them: quads that face one view's eye, in a snapshot of their own beside everything else, and the
// surfaces that they are. Any thread.
#pragma once

#include <cstdint>
#include <memory>

#include "rt/surfaces/surface.h"
#include "rt/tracer.h"

namespace sideray::rt {

bool has_sprites(const model::Snapshot& snapshot);

// Sprites that are in the picture at least in part, hidden or not.
uint64_t count_sprites_in_view(const model::Snapshot& snapshot, const TraceView& view);

// The snapshot with an instance of two triangles a sprite for each system: triangles 2 i and 2 i + 1 are sprite i.
// Instances before them stay as they are. Rays of LayerSet::with_sprites alone meet them. `height`: of the picture.
std::shared_ptr<const model::Snapshot> with_sprite_quads(const model::Snapshot& snapshot, const TraceView& view,
                                                         uint32_t height);

// Whether too little alpha is there (sr_sprite_absent); `hit` is on an instance of quads.
bool sprite_discards(const model::Snapshot& snapshot, const Hit& hit);

// surface_point() on an instance of quads. The ray ends at what is opaque: sprites fade before it.
SurfacePoint sprite_point(const model::Snapshot& snapshot, const Hit& hit, const Ray& ray, Cone cone);

}  // namespace sideray::rt
