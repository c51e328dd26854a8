// Describes a mesh in a pose that changes from commit to commit, as the acceleration structures keep it. Any thread may
// read it.
#pragma once

#include <cstdint>
#include <memory>

#include "model/snapshot.h"

namespace sideray::rt {

enum class PoseChange {
  none,    // nothing changed since the last scene
  refit,   // vertices moved, a tree of the pose that was built last still serves
  rebuild  // vertices moved too far from it
};

struct PosedMesh {
  std::shared_ptr<const model::Mesh> neutral, mesh;  // differ in positions and bounds alone
  uint64_t pose;                                     // stays when the mesh moves; not 0
  PoseChange change;
};

}  // namespace sideray::rt
