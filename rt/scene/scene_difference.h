// Compares two snapshots of one scene. Any thread may call it.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

// Returns whether the snapshots differ only in the positions of instances and vertices.
bool differ_in_places_only(const model::Snapshot& a, const model::Snapshot& b);
// Returns whether the snapshots are equal except for their revisions, as after a commit without changes.
bool are_equal(const model::Snapshot& a, const model::Snapshot& b);

// Returns bounds that hold for any rotation of the sprite.
model::Bounds bounds_of(const model::Sprite& sprite);

// Describes a difference between two snapshots, with bounds that contain it in both.
struct Mover {
  enum class Kind { surface, sprites, light } kind;
  size_t index;          // of the instance, particle system or light
  model::Bounds bounds;  // for a light: everything that it can light
};
// Returns everything that has moved, sways or looks different; nullopt if that may be the whole scene.
std::optional<std::vector<Mover>> find_movers(const model::Snapshot& a, const model::Snapshot& b);

}  // namespace sideray::rt
