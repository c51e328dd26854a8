#include "rt/scene/scene_difference.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "model/mesh.h"

namespace sideray::rt {
namespace {

bool same_materials(const model::Snapshot& a, const model::Snapshot& b) {
  // Unused bytes may differ too, which costs only a reset of the history.
  if (a.materials.size() != b.materials.size()) return false;
  return a.materials.empty() ||
         std::memcmp(a.materials.data(), b.materials.data(), a.materials.size() * sizeof(model::Material)) == 0;
}

bool same_shader(const sideray_shader_desc& a, const sideray_shader_desc& b) {
  return a.shade == b.shade && a.user == b.user && a.shadow_lights == b.shadow_lights &&
         a.radiance_space == b.radiance_space && a.radiance_scale == b.radiance_scale;
}

// Returns whether fixed function and host's shader are the same.
bool same_shading(const model::Snapshot& a, const model::Snapshot& b) {
  const bool same_fixed = a.fixed == b.fixed || (a.fixed && b.fixed && *a.fixed == *b.fixed);
  return same_fixed && same_shader(a.shader, b.shader);
}

// Returns whether the meshes differ only in their vertices' positions and normals.
bool differ_in_vertices_only(const model::Mesh& a, const model::Mesh& b) {
  return a.uv0 == b.uv0 && a.uv1 == b.uv1 && a.colors == b.colors && model::same_triangles(a, b);
}

bool same_material(const model::Material& a, const model::Material& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

bool same_sprite(const model::Sprite& a, const model::Sprite& b) {
  return a.position == b.position && a.half_size == b.half_size && a.rotation == b.rotation && a.color == b.color &&
         a.cell == b.cell;
}

bool same_particles(const model::ParticleSystem& a, const model::ParticleSystem& b) {
  return std::memcmp(&a.desc, &b.desc, sizeof(a.desc)) == 0 && std::ranges::equal(a.sprites, b.sprites, same_sprite);
}

// Lines and points are hit only by primary rays, so movers leave them out.
bool same_thin(const model::Snapshot& a, const model::Snapshot& b) {
  return std::ranges::equal(a.thin, b.thin, [&](const model::Instance& i, const model::Instance& j) {
    return a.meshes[i.mesh] == b.meshes[j.mesh] && i.material == j.material && i.surface_id == j.surface_id &&
           i.local_from_object == j.local_from_object;
  });
}

void add_box(model::Bounds& all, const model::Bounds& box) {
  if (box.empty()) return;
  all.add(box.minimum);
  all.add(box.maximum);
}

void add_sprites(model::Bounds& all, const model::ParticleSystem& system) {
  for (const model::Sprite& sprite : system.sprites) add_box(all, bounds_of(sprite));
}

bool has_end(const model::Light& light) {
  return light.type != SIDERAY_LIGHT_DIRECTIONAL && light.range > 0.0f;
}

void add_reach(model::Bounds& all, const model::Light& light) {
  all.add(light.position - light.range);
  all.add(light.position + light.range);
}

// Compares instances of the same index in two snapshots whose names agree.
class InstanceComparison {
 public:
  InstanceComparison(const model::Snapshot& a, const model::Snapshot& b)
      : a_(a), b_(b), wind_blows_(a.time_s != b.time_s || !same_winds(a, b)) {}

  bool are_equal(const model::Instance& i, const model::Instance& j) const {
    return a_.meshes[i.mesh] == b_.meshes[j.mesh] && i.material == j.material &&
           i.local_from_object == j.local_from_object && i.surface_id == j.surface_id && i.visibility == j.visibility &&
           i.user == j.user && i.solid == j.solid && i.wind == j.wind && i.wind_phase == j.wind_phase &&
           !(i.wind != 0 && wind_blows_) && same_material(a_.materials[i.material], b_.materials[j.material]);
  }

 private:
  static bool same_winds(const model::Snapshot& a, const model::Snapshot& b) {
    return std::ranges::equal(a.winds, b.winds, [](const model::Wind& x, const model::Wind& y) {
      return std::memcmp(&x.desc, &y.desc, sizeof(x.desc)) == 0;
    });
  }

  const model::Snapshot &a_, &b_;
  const bool wind_blows_;
};

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
  if (!same_materials(a, b) || !same_shading(a, b)) return false;
  // Equal names mean that indices agree in both snapshots.
  if (a.instance_names != b.instance_names || !same_thin(a, b)) return false;
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

model::Bounds bounds_of(const model::Sprite& sprite) {
  const float radius = glm::length(sprite.half_size);
  return {sprite.position - radius, sprite.position + radius};
}

std::optional<std::vector<Mover>> find_movers(const model::Snapshot& a, const model::Snapshot& b) {
  if (a.origin != b.origin || a.environment != b.environment || a.textures != b.textures || !same_shading(a, b) ||
      a.instance_names != b.instance_names || a.material_names != b.material_names ||
      a.instances.size() != b.instances.size() || a.materials.size() != b.materials.size() ||
      a.lights.size() != b.lights.size() || !same_thin(a, b))
    return std::nullopt;
  // Translucency decides which rays are traced.
  for (size_t i = 0; i < a.materials.size(); ++i)
    if (a.materials[i].translucent != b.materials[i].translucent || a.materials[i].traceable != b.materials[i].traceable)
      return std::nullopt;
  std::vector<Mover> movers;
  const InstanceComparison instances(a, b);
  for (size_t i = 0; i < a.instances.size(); ++i) {
    if (instances.are_equal(a.instances[i], b.instances[i])) continue;
    model::Bounds bounds = a.instances[i].bounds;
    add_box(bounds, b.instances[i].bounds);
    movers.push_back({Mover::Kind::surface, i, bounds});
  }
  for (size_t i = 0; i < std::max(a.particles.size(), b.particles.size()); ++i) {
    const bool both = i < a.particles.size() && i < b.particles.size();
    if (both && same_particles(a.particles[i], b.particles[i])) continue;
    model::Bounds bounds;
    for (const model::Snapshot* snapshot : {&a, &b})
      if (i < snapshot->particles.size()) add_sprites(bounds, snapshot->particles[i]);
    movers.push_back({Mover::Kind::sprites, i, bounds});
  }
  for (size_t i = 0; i < a.lights.size(); ++i) {
    if (a.lights[i] == b.lights[i]) continue;
    if (!has_end(a.lights[i]) || !has_end(b.lights[i])) return std::nullopt;
    model::Bounds bounds;
    add_reach(bounds, a.lights[i]);
    add_reach(bounds, b.lights[i]);
    movers.push_back({Mover::Kind::light, i, bounds});
  }
  return movers;
}

}  // namespace sideray::rt
