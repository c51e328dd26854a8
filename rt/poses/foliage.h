// Poses plants in the wind for rays: each pose is a mesh of its own, in a snapshot beside the committed one. One thread
// at a time may call it; it uses the executor's threads.
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
  glm::vec3 eye{0.0f};                  // for the cull angle; in local space
  CullRules cull{};
  bool operator==(const FoliageOptions&) const = default;
};

// Returns a vertex (object space) moved by wind at a phase from model::wind_phase().
glm::vec3 moved_by_wind(const model::Wind& wind, glm::vec3 phase, glm::vec3 position);

// Returns the shared pose whose phase is cyclically nearest to an instance's.
uint32_t nearest_pose(float phase, uint32_t poses);

class Foliage {
 public:
  // Returns a snapshot with poses, or the same snapshot if nothing is posed. Instances keep their indices, and meshes
  // that are not poses too. Poses have the same bits for any thread count.
  std::shared_ptr<const model::Snapshot> pose(std::shared_ptr<const model::Snapshot> snapshot,
                                              const FoliageOptions& options, Executor& executor);
  // Returns the poses of the last call, in the order of the snapshot's meshes.
  std::span<const PosedMesh> posed() const { return posed_; }

  struct Counts {
    size_t poses = 0, refits = 0, rebuilds = 0;
  };
  Counts counts() const;

 private:
  // Key: mesh, wind index + 1, then either instance name and 0, or 0 and the number of the shared pose.
  using Key = std::tuple<const model::Mesh*, uint32_t, uint32_t, uint32_t>;
  struct Pose {
    uint64_t id = 0;
    std::shared_ptr<const model::Mesh> neutral;
    std::vector<std::shared_ptr<model::Mesh>> meshes;  // used in turn, because earlier snapshots may still be read
    size_t current = 0;
    model::Wind wind{};
    glm::vec3 phase{0.0f};
    PoseQuality quality;
    PoseChange change = PoseChange::none;
    uint32_t mesh_index = 0;  // in the snapshot
    bool used = false, moves = false;
  };

  // Returns each instance's pose, null without wind. `in_use` receives each pose once, in the order of instances.
  std::vector<Pose*> choose(const model::Snapshot& snapshot, uint32_t poses, std::vector<Pose*>& in_use);
  void use(Pose& pose, const model::Snapshot& snapshot, const model::Instance& instance, float phase);
  static void make_room(Pose& pose);
  static void move(const std::vector<Pose*>& poses, Executor& executor);

  std::map<Key, Pose> poses_;
  std::vector<PosedMesh> posed_;
  uint64_t next_id_ = 1;
};

}  // namespace sideray::rt
