// Describes what the acceleration structures are built from besides a snapshot. Any thread may read it.
#pragma once

#include <cstdint>
#include <span>

#include "rt/poses/posed_mesh.h"

namespace sideray::rt {

class Executor;

// Holds what a snapshot does not say of itself.
struct SceneUpdate {
  std::span<const PosedMesh> posed = {};  // of the snapshot's meshes; those of the scene before keep their structures
  std::span<const uint8_t> culled = {};   // 1 = no ray hits the instance; missing = 0
  Executor* executor = nullptr;           // moves poses on its threads
};

}  // namespace sideray::rt
