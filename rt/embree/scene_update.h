// What the acceleration structures are built of besides a snapshot. Any thread.
#pragma once

#include <cstdint>
#include <span>

#include "rt/poses/posed_mesh.h"

namespace sideray::rt {

class Executor;

// What a snapshot does not say of itself.
struct SceneUpdate {
  std::span<const PosedMesh> posed = {};  // of the snapshot's meshes; those of the scene before keep their structures
  std::span<const uint8_t> culled = {};   // 1 = no ray meets the instance; missing = 0
  Executor* executor = nullptr;           // poses are taken over on its threads
};

}  // namespace sideray::rt
