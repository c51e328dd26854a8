// Describes a mesh in a pose that changes between commits, for the acceleration structures. Any thread may read it.
#pragma once

#include <cstdint>
#include <memory>

#include "model/snapshot.h"

namespace sideray::rt {

enum class PoseChange {
  none,    // unchanged since the last scene
  refit,   // vertices moved, but the built tree still suits them
  rebuild  // vertices moved too far for the built tree
};

struct PosedMesh {
  std::shared_ptr<const model::Mesh> neutral, mesh;  // differ only in positions and bounds
  uint64_t pose;                                     // the pose's number, which stays when the mesh moves; not 0
  PoseChange change;
};

}  // namespace sideray::rt
