// Describes what the acceleration structures are built from besides a snapshot. Any thread may read it.
#pragma once

#include <cstdint>
#include <span>

#include "rt/poses/posed_mesh.h"

namespace sideray::rt {

class Executor;

// Holds what the snapshot itself does not contain.
struct SceneUpdate {
  std::span<const PosedMesh> posed = {};  // poses of the snapshot's meshes; poses of the last update keep their
                                          // structures
  std::span<const uint8_t> culled = {};   // 1 = no ray hits the instance; missing = 0
  Executor* executor = nullptr;           // moves poses on its threads
};

}  // namespace sideray::rt
