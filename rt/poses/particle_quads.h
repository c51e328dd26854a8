// Turns sprites into geometry for rays: quads that face one view's eye, in a snapshot of their own beside everything
// else. Any thread may call it.
#pragma once

#include <cstdint>
#include <memory>

#include "model/snapshot.h"
#include "rt/base/view.h"

namespace sideray::rt {

bool has_sprites(const model::Snapshot& snapshot);

// Counts the sprites that are in the picture at least in part, hidden or not.
uint64_t count_sprites_in_view(const model::Snapshot& snapshot, const TraceView& view);

// Returns the snapshot with an instance of two triangles a sprite for each system: triangles 2 i and 2 i + 1 are sprite
// i. Instances before them stay as they are. Only rays of LayerSet::with_sprites hit them. `height` is the picture's.
std::shared_ptr<const model::Snapshot> with_sprite_quads(const model::Snapshot& snapshot, const TraceView& view,
                                                         uint32_t height);

}  // namespace sideray::rt
