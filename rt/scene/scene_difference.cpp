#include "rt/scene/scene_difference.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "model/mesh.h"

namespace sideray::rt {
namespace {

bool same_materials(const model::Snapshot& a, const model::Snapshot& b) {
  // Bytes without a meaning may differ too, which costs a history and nothing else.
  return a.materials.size() == b.materials.size() &&
         std::memcmp(a.materials.data(), b.materials.data(), a.materials.size() * sizeof(model::Material)) == 0;
}

bool same_shader(const sideray_shader_desc& a, const sideray_shader_desc& b) {
  return a.shade == b.shade && a.user == b.user && a.shadow_lights == b.shadow_lights &&
         a.radiance_space == b.radiance_space && a.radiance_scale == b.radiance_scale;
}

// Returns whether the meshes differ only in where their vertices are and which way they face.
bool differ_in_vertices_only(const model::Mesh& a, const model::Mesh& b) {
  return a.uv0 == b.uv0 && a.uv1 == b.uv1 && a.colors == b.colors && model::same_triangles(a, b);
}

// Compares each mesh once, however many instances it has.
class MeshComparison {
 public:
  MeshComparison(const model::Snapshot& a, const model::Snapshot& b) : a_(a), b_(b), known_(a.meshes.size()) {}

  bool same_surface(uint32_t mesh_a, uint32_t mesh_b) {
    const std::shared_ptr<const model::Mesh>&a = a_.meshes[mesh_a], &b = b_.meshes[mesh_b];
    if (a == b) return true;
    Known& known = known_[mesh_a];
    if (known.other != b.get()) known = {b.get(), differ_in_vertices_only(*a, *b)};
    return known.same;
  }

 private:
  struct Known {
    const model::Mesh* other = nullptr;
    bool same = false;
  };
  const model::Snapshot &a_, &b_;
  std::vector<Known> known_;
};

}  // namespace

bool differ_in_places_only(const model::Snapshot& a, const model::Snapshot& b) {
  if (&a == &b) return true;
  if (a.origin != b.origin || a.environment != b.environment || a.textures != b.textures || a.lights != b.lights)
    return false;
  if (!same_materials(a, b) || !same_shader(a.shader, b.shader)) return false;
  // Equal names mean that the indices of one snapshot are those of the other.
  if (a.instance_names != b.instance_names) return false;
  MeshComparison meshes(a, b);
  return std::equal(a.instances.begin(), a.instances.end(), b.instances.begin(), b.instances.end(),
                    [&](const model::Instance& i, const model::Instance& j) {
                      return meshes.same_surface(i.mesh, j.mesh) && i.material == j.material &&
                             i.surface_id == j.surface_id && i.visibility == j.visibility && i.user == j.user;
                    });
}

bool are_equal(const model::Snapshot& a, const model::Snapshot& b) {
  if (&a == &b) return true;
  return differ_in_places_only(a, b) && a.meshes == b.meshes &&
         std::ranges::equal(a.instances, b.instances, {}, &model::Instance::local_from_object,
                            &model::Instance::local_from_object);
}

}  // namespace sideray::rt
