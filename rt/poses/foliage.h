// Poses what the wind moves as rays hit it: each pose in a mesh of its own, in a snapshot beside the committed one. One
// thread at a time may call it; it works on the executor's.
#pragma once

#include <sideray/renderer.h>

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
  uint32_t poses = SIDERAY_POSES_REST;  // 1..256: pose c of a mesh is at phase c / poses of its cycle
  float cull_angle_deg = 0.0f;          // 0 = none
  glm::vec3 eye{0.0f};                  // local space; the cull angle is measured from it
  CullRules cull{};
  bool operator==(const FoliageOptions&) const = default;
};

// Returns where wind moves a vertex (object space) at a phase of model::wind_phase().
glm::vec3 moved_by_wind(const model::Wind& wind, glm::vec3 phase, glm::vec3 position);

// Returns the shared pose whose phase is nearest to an instance's, around the cycle.
uint32_t nearest_pose(float phase, uint32_t poses);

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
  // A key consists of mesh, index + 1 of the wind, and the name of the instance, or 0 and which of the shared poses.
  using Key = std::tuple<const model::Mesh*, uint32_t, uint32_t, uint32_t>;
  struct Pose {
    uint64_t id = 0;
    std::shared_ptr<const model::Mesh> neutral;
    std::vector<std::shared_ptr<model::Mesh>> meshes;  // used in rotation: earlier snapshots may still be read
    size_t current = 0;
    model::Wind wind{};
    glm::vec3 phase{0.0f};
    PoseQuality quality;
    PoseChange change = PoseChange::none;
    uint32_t mesh_index = 0;  // index in the snapshot
    bool used = false, moves = false;
  };

  // Returns the pose of each instance, null without wind; `in_use` gets each of them once, in the order of instances.
  std::vector<Pose*> choose(const model::Snapshot& snapshot, uint32_t poses, std::vector<Pose*>& in_use);
  void use(Pose& pose, const model::Snapshot& snapshot, const model::Instance& instance, float phase);
  static void make_room(Pose& pose);
  static void move(const std::vector<Pose*>& poses, Executor& executor);

  std::map<Key, Pose> poses_;
  std::vector<PosedMesh> posed_;
  uint64_t next_id_ = 1;
};

}  // namespace sideray::rt
