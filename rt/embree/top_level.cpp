#include "rt/embree/top_level.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sideray::rt {
namespace {

glm::vec3 largest_corner(const model::Bounds& b) {
  return glm::max(glm::abs(b.minimum), glm::abs(b.maximum));
}

float largest_component(glm::vec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

// Returns an upper bound, at least 1, of the length in object space of a unit vector of local space.
double inverse_growth(const glm::mat4x3& m) {
  // Embree inverts the matrix in floats: if the determinant is out of their range, every ray becomes NaN.
  const float determinant = glm::determinant(glm::mat3(m[0], m[1], m[2]));
  if (!std::isnormal(determinant)) return std::numeric_limits<double>::infinity();
  const glm::dmat3 inverse = glm::inverse(glm::dmat3(glm::dvec3(m[0]), glm::dvec3(m[1]), glm::dvec3(m[2])));
  double sum = 1.0;
  for (int c = 0; c < 3; ++c) sum = std::max(sum, glm::length(inverse[c]) * 3.0);
  return sum;
}

// Embree's limit is 1.8e18. It applies in every object's space, where Debian's build asserts it.
constexpr double largest_coordinate = 1e18;

// Returns how far from the local origin a ray may start without leaving Embree's range in the instance's object space.
double limit_of_origins(const model::Instance& instance, double growth) {
  return largest_coordinate / growth - 3.0 * static_cast<double>(largest_component(instance.local_from_object[3]));
}

bool same_but_for_place(const glm::mat4x3& a, const glm::mat4x3& b) {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

// Returns the largest local coordinate in the instance's arithmetic.
float reach(const model::Instance& instance, const model::Mesh& mesh) {
  const glm::mat4x3& m = instance.local_from_object;
  const glm::mat3 absolute(glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2]));
  return largest_component(absolute * largest_corner(mesh.bounds) + glm::abs(m[3]));
}

}  // namespace

// Recomputes what depends on transform and mesh only if one of them changed.
void TopLevel::look(Entry& entry, const model::Instance& instance, const MeshScene& mesh) {
  const bool same = entry.mesh_scene == mesh.scene.get() && entry.version == mesh.version && entry.mesh == &mesh &&
                    entry.transform == instance.local_from_object;
  if (same) return;
  entry.stale = true;
  entry.mesh = &mesh;
  if (entry.growth == 0.0 || !same_but_for_place(entry.transform, instance.local_from_object))
    entry.growth = inverse_growth(instance.local_from_object);
  entry.transform = instance.local_from_object;
  entry.version = mesh.version;
  entry.reach = reach(instance, *mesh.mesh);
  entry.limit = static_cast<float>(limit_of_origins(instance, entry.growth));
}

void TopLevel::detach(Entry& entry, uint32_t id) {
  if (!entry.attached) return;
  rtcDetachGeometry(scene.get(), id);
  entry.attached = false;
  ++changes_.detached;
}

void TopLevel::apply(RTCDevice device, Entry& entry, uint32_t id) {
  const bool is_new = !entry.geometry;
  if (is_new) entry.geometry.reset(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
  const RTCGeometry geometry = entry.geometry.get();
  if (!geometry) return;
  if (entry.stale || entry.mask != entry.wanted) {
    if (entry.mesh_scene != entry.mesh->scene.get()) rtcSetGeometryInstancedScene(geometry, entry.mesh->scene.get());
    static_assert(sizeof(entry.transform) == 12 * sizeof(float));
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &entry.transform[0][0]);
    if (entry.mask != entry.wanted) rtcSetGeometryMask(geometry, entry.wanted);
    rtcCommitGeometry(geometry);
    entry.mesh_scene = entry.mesh->scene.get();
    entry.mask = entry.wanted;
    entry.stale = false;
    changes_.changed += entry.attached;
  }
  if (entry.attached) return;
  rtcAttachGeometryByID(scene.get(), geometry, id);
  entry.attached = true;
  ++changes_.attached;
}

void TopLevel::set_up(RTCDevice device, const model::Snapshot& snapshot, const MeshScenes& meshes,
                      std::span<const uint8_t> culled, MaskOf mask_of) {
  changes_ = {};
  mask_bits = 0;
  magnitude = 0;
  if (!scene) {
    scene.reset(rtcNewScene(device));
    check_device(device, "adding a scene");
    rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | embree::filter_flag));
  }
  for (size_t i = snapshot.instances.size(); i < entries_.size(); ++i) detach(entries_[i], static_cast<uint32_t>(i));
  entries_.resize(snapshot.instances.size());
  std::vector<const MeshScene*> mesh_scenes(snapshot.meshes.size());
  for (size_t i = 0; i < mesh_scenes.size(); ++i)
    if (const auto found = meshes.find(snapshot.meshes[i].get()); found != meshes.end())
      mesh_scenes[i] = found->second.get();
  for (size_t i = 0; i < entries_.size(); ++i) {
    const model::Instance& instance = snapshot.instances[i];
    const MeshScene& mesh = *mesh_scenes[instance.mesh];
    Entry& entry = entries_[i];
    entry.wanted = i < culled.size() && culled[i] ? 0 : mask_of(snapshot.materials[instance.material], instance);
    if (entry.wanted == 0) continue;
    look(entry, instance, mesh);
    if (!mesh.scene || !std::isfinite(entry.reach)) entry.wanted = 0;
    if (entry.wanted != 0) magnitude = std::max(magnitude, entry.reach);
  }
  // Leaves out an instance so flat or small beside the others that no ray from among them would be in its range.
  const float least_limit = 1e3f * magnitude;
  float limit = static_cast<float>(largest_coordinate);
  for (size_t i = 0; i < entries_.size(); ++i) {
    Entry& entry = entries_[i];
    if (entry.wanted == 0 || !(entry.limit > least_limit)) {
      detach(entry, static_cast<uint32_t>(i));
      continue;
    }
    apply(device, entry, static_cast<uint32_t>(i));
    limit = std::min(limit, entry.limit);
    mask_bits |= entry.wanted;
  }
  origin_limit = limit;
  check_device(device, "adding instances");
}

void TopLevel::commit(RTCDevice device) {
  rtcCommitScene(scene.get());
  check_device(device, "building the scene");
}

}  // namespace sideray::rt
