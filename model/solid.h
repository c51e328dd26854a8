// Tests whether a mesh encloses a volume: then rays enter it at front faces and leave it at back faces. Any thread may
// call it.
#pragma once

#include "model/snapshot.h"

namespace sideray::model {

// Returns whether every edge has a neighbour that runs the other way. Vertices within 1e-5 of the mesh's radius count
// as one, since seams of normals and texture coordinates repeat them. A mesh without area is not closed.
bool is_closed(const Mesh& mesh);

}  // namespace sideray::model
