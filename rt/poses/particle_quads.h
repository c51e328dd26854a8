// Makes geometry for rays from sprites: quads that face one view's eye, added to a copy of the snapshot. Any thread may
// call it.
#pragma once

#include <cstdint>
#include <memory>

#include "model/snapshot.h"
#include "rt/base/view.h"

namespace sideray::rt {

bool has_sprites(const model::Snapshot& snapshot);

// Counts the sprites that are at least partly inside the picture, occluded or not.
uint64_t count_sprites_in_view(const model::Snapshot& snapshot, const TraceView& view);

// Returns the snapshot with an instance for each system, in which triangles 2 i and 2 i + 1 are sprite i. Other
// instances keep their indices. Only rays of LayerSet::with_sprites hit sprites. `height` is the picture's, in pixels.
std::shared_ptr<const model::Snapshot> with_sprite_quads(const model::Snapshot& snapshot, const TraceView& view,
                                                         uint32_t height);

}  // namespace sideray::rt
