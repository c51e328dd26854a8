#include "rt/poses/foliage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/wind.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {
namespace {

constexpr size_t vertices_in_piece = 4096;

shading::SrWind shading_wind(const model::Wind& wind) {
  const sideray_wind_desc& d = wind.desc;
  return {glm::vec3(d.direction[0], d.direction[1], d.direction[2]),
          d.amplitude,
          d.height,
          d.branch_amplitude,
          d.leaf_amplitude,
          d.wavelength};
}

bool same_wind(const sideray_wind_desc& a, const sideray_wind_desc& b) {
  return std::equal(a.direction, a.direction + 3, b.direction) && a.amplitude == b.amplitude &&
         a.frequency == b.frequency && a.height == b.height && a.branch_amplitude == b.branch_amplitude &&
         a.branch_frequency == b.branch_frequency && a.leaf_amplitude == b.leaf_amplitude &&
         a.leaf_frequency == b.leaf_frequency && a.wavelength == b.wavelength;
}

void move_vertices(const model::Mesh& neutral, const model::Wind& wind, glm::vec3 phase, size_t first, size_t last,
                   glm::vec3* positions) {
  const shading::SrWind w = shading_wind(wind);
  const shading::SrWindPhase p{phase.x, phase.y, phase.z};
  for (size_t i = first; i < last; ++i) positions[i] = neutral.positions[i] + sr_wind(w, p, neutral.positions[i]);
}

// Computes bounds as add_mesh() does: from vertices that triangles use.
model::Bounds bounds_of(const model::Mesh& mesh) {
  model::Bounds bounds;
  for (const glm::uvec3 t : mesh.triangles)
    for (int k = 0; k < 3; ++k) bounds.add(mesh.positions[t[k]]);
  return bounds;
}

std::shared_ptr<model::Mesh> copy_of(const model::Mesh& neutral) {
  auto mesh = std::make_shared<model::Mesh>();
  mesh->positions.reserve(neutral.positions.size() + 1);  // Embree reads 16 bytes at the last vertex
  *mesh = neutral;
  if (mesh->positions.capacity() == mesh->positions.size()) mesh->positions.reserve(mesh->positions.size() + 1);
  return mesh;
}

}  // namespace

glm::vec3 moved_by_wind(const model::Wind& wind, glm::vec3 phase, glm::vec3 position) {
  return position + sr_wind(shading_wind(wind), {phase.x, phase.y, phase.z}, position);
}

uint32_t nearest_pose(float phase, uint32_t poses) {
  const double share = double{phase} - std::floor(double{phase});
  return static_cast<uint32_t>(share * poses + 0.5) % poses;
}

Foliage::Counts Foliage::counts() const {
  Counts counts{posed_.size(), 0, 0};
  for (const PosedMesh& p : posed_) {
    counts.refits += p.change == PoseChange::refit;
    counts.rebuilds += p.change == PoseChange::rebuild;
  }
  return counts;
}

void Foliage::use(Pose& pose, const model::Snapshot& snapshot, const model::Instance& instance, float phase) {
  pose.used = true;
  const model::Wind& wind = snapshot.winds[instance.wind - 1];
  const glm::vec3 wanted = model::wind_phase(wind, snapshot.time_s, phase);
  if (pose.id == 0) {
    pose.id = next_id_++;
    pose.neutral = snapshot.meshes[instance.mesh];
    pose.moves = true;
  } else {
    pose.moves = pose.phase != wanted || !same_wind(pose.wind.desc, wind.desc);
  }
  pose.phase = wanted;
  pose.wind = wind;
}

std::vector<Foliage::Pose*> Foliage::choose(const model::Snapshot& snapshot, uint32_t poses,
                                            std::vector<Pose*>& in_use) {
  std::vector<Pose*> of_instance(snapshot.instances.size(), nullptr);
  for (size_t i = 0; i < of_instance.size(); ++i) {
    const model::Instance& instance = snapshot.instances[i];
    if (instance.wind == 0) continue;
    const model::Mesh* mesh = snapshot.meshes[instance.mesh].get();
    Key key(mesh, instance.wind, snapshot.instance_names[i].name, 0);
    float phase = instance.wind_phase;
    if (poses != SIDERAY_POSES_ALL) {
      const uint32_t shared = nearest_pose(phase, poses);
      key = {mesh, instance.wind, 0, shared};
      phase = static_cast<float>(shared) / static_cast<float>(poses);
    }
    Pose& pose = poses_[key];
    if (!pose.used) {
      use(pose, snapshot, instance, phase);
      in_use.push_back(&pose);
    }
    of_instance[i] = &pose;
  }
  return of_instance;
}

// Selects a mesh that no snapshot holds; adds one if there is none.
void Foliage::make_room(Pose& pose) {
  for (size_t i = 0; i < pose.meshes.size(); ++i)
    if (pose.meshes[i].use_count() == 1) {
      pose.current = i;
      return;
    }
  pose.current = pose.meshes.size();
  pose.meshes.push_back(copy_of(*pose.neutral));
}

void Foliage::move(const std::vector<Pose*>& poses, Executor& executor) {
  struct Piece {
    Pose* pose;
    size_t first, last;
  };
  std::vector<Pose*> moving;
  for (Pose* pose : poses) {
    pose->change = PoseChange::none;
    if (pose->moves) moving.push_back(pose);
  }
  executor.run(moving.size(), [&](size_t i, uint32_t) { make_room(*moving[i]); });
  std::vector<Piece> pieces;
  for (Pose* pose : moving)
    for (size_t first = 0; first < pose->neutral->positions.size(); first += vertices_in_piece)
      pieces.push_back({pose, first, std::min(first + vertices_in_piece, pose->neutral->positions.size())});
  executor.run(pieces.size(), [&](size_t i, uint32_t) {
    const Piece& p = pieces[i];
    move_vertices(*p.pose->neutral, p.pose->wind, p.pose->phase, p.first, p.last,
                  p.pose->meshes[p.pose->current]->positions.data());
  });
  executor.run(moving.size(), [&](size_t i, uint32_t) {
    Pose& pose = *moving[i];
    model::Mesh& mesh = *pose.meshes[pose.current];
    mesh.bounds = bounds_of(mesh);
    pose.change = pose.quality.growth(mesh) < PoseQuality::worst_growth ? PoseChange::refit : PoseChange::rebuild;
    if (pose.change == PoseChange::rebuild) pose.quality.build(mesh);
  });
}

std::shared_ptr<const model::Snapshot> Foliage::pose(std::shared_ptr<const model::Snapshot> snapshot,
                                                     const FoliageOptions& options, Executor& executor) {
  posed_.clear();
  if (options.poses == SIDERAY_POSES_REST || snapshot->winds.empty()) {
    poses_.clear();
    return snapshot;
  }
  for (auto& [key, pose] : poses_) pose.used = false;
  std::vector<Pose*> poses;
  const std::vector<Pose*> of_instance = choose(*snapshot, options.poses, poses);
  std::erase_if(poses_, [](const auto& entry) { return !entry.second.used; });
  if (poses.empty()) return snapshot;
  move(poses, executor);

  auto result = std::make_shared<model::Snapshot>(*snapshot);
  for (Pose* pose : poses) {
    pose->mesh_index = static_cast<uint32_t>(result->meshes.size());
    result->meshes.push_back(pose->meshes[pose->current]);
    posed_.push_back({pose->neutral, pose->meshes[pose->current], pose->id, pose->change});
  }
  for (size_t i = 0; i < of_instance.size(); ++i)
    if (of_instance[i]) result->instances[i].mesh = of_instance[i]->mesh_index;
  return result;
}

}  // namespace sideray::rt
