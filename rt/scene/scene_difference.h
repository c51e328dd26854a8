// Finds what two snapshots of one scene have in common. Any thread may call it.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

// Returns whether the snapshots differ only in where instances and vertices are.
bool differ_in_places_only(const model::Snapshot& a, const model::Snapshot& b);
// Returns whether they do not even differ there. Commits that change nothing are equal except for their revisions.
bool are_equal(const model::Snapshot& a, const model::Snapshot& b);

// However the sprite is turned.
model::Bounds bounds_of(const model::Sprite& sprite);

// Something that differs between two snapshots, with bounds that hold it in both.
struct Mover {
  enum class Kind { surface, sprites, light } kind;
  size_t index;          // of the instance, system or light
  model::Bounds bounds;  // of a light: all that it can light
};
// Returns what has moved, sways or looks different; nullopt if that may be everything.
std::optional<std::vector<Mover>> find_movers(const model::Snapshot& a, const model::Snapshot& b);

}  // namespace sideray::rt
