// Finds what two snapshots of one scene have in common. Any thread may call it.
#pragma once

#include "model/snapshot.h"

namespace sideray::rt {

// Returns whether the snapshots differ only in where instances and vertices are.
bool differ_in_places_only(const model::Snapshot& a, const model::Snapshot& b);
// Returns whether they do not even differ there. Commits that change nothing are equal, but for their revisions.
bool are_equal(const model::Snapshot& a, const model::Snapshot& b);

}  // namespace sideray::rt
