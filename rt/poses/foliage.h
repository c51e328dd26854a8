// Poses what the wind moves as rays hit it: each pose in a mesh of its own, in a snapshot beside the committed one. One
// thread at a time may call it; it works on the executor's.
#pragma once

#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/executor.h"
#include "rt/poses/angle_cull.h"
#include "rt/poses/pose_quality.h"
#include "rt/poses/posed_mesh.h"

namespace sideray::rt {

struct FoliageOptions {
  sideray_foliage mode = SIDERAY_FOLIAGE_STATIC;
  uint32_t shared_copies = 1;   // 1..256; copy c is at phase c / copies of its cycle
  uint32_t unique_cap = 256;    // the first instances of a mesh and wind that get poses of their own; 0 = all
  float cull_angle_deg = 0.0f;  // 0 = none
  glm::vec3 eye{0.0f};          // local space; the cull angle is measured from it
  CullRules cull{};
  bool operator==(const FoliageOptions&) const = default;
};

// Returns the copy whose phase is nearest to an instance's, around the cycle.
uint32_t nearest_copy(float phase, uint32_t copies);

class Foliage {
 public:
  // Returns a snapshot with poses, or the snapshot itself where nothing is posed. Instances keep their places; meshes
  // before the posed ones too. Poses are the same bits for any thread count.
  std::shared_ptr<const model::Snapshot> pose(std::shared_ptr<const model::Snapshot> snapshot,
                                              const FoliageOptions& options, Executor& executor);
  // Returns the poses of the last call, in the order of the snapshot's meshes.
  std::span<const PosedMesh> posed() const { return posed_; }

  struct Counts {
    size_t poses = 0, refits = 0, rebuilds = 0;
  };
  Counts counts() const;

 private:
  // A key consists of mesh, index + 1 of the wind, name of the instance or 0, and copy.
  using Key = std::tuple<const model::Mesh*, uint32_t, uint32_t, uint32_t>;
  struct Pose {
    uint64_t id = 0;
    std::shared_ptr<const model::Mesh> neutral;
    std::vector<std::shared_ptr<model::Mesh>> meshes;  // used in rotation: snapshots before may still be read
    size_t current = 0;
    model::Wind wind{};
    glm::vec3 phase{0.0f};
    PoseQuality quality;
    PoseChange change = PoseChange::none;
    uint32_t mesh_index = 0;  // index in the snapshot
    bool used = false, moves = false;
  };

  std::vector<Pose*> choose(const model::Snapshot& snapshot, const FoliageOptions& options,
                            std::vector<Pose*>& of_instance);
  Pose& pose_of(const Key& key, const model::Snapshot& snapshot, uint32_t mesh, float phase);
  static void make_room(Pose& pose);
  static void move(const std::vector<Pose*>& poses, Executor& executor);

  std::map<Key, Pose> poses_;
  std::vector<PosedMesh> posed_;
  uint64_t next_id_ = 1;
};

}  // namespace sideray::rt
