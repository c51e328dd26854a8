#include "bridge/plan/scene_facts.h"

#include <algorithm>
#include <map>

#include "bridge/base/opaque_rays.h"
#include "model/material.h"

namespace sideray::bridge {
namespace {

// Returns whether a mesh is two triangles in one plane that share an edge: no ray hits both.
bool is_flat_quad(const model::Mesh& mesh) {
  if (mesh.triangles.size() != 2) return false;
  const glm::uvec3 a = mesh.triangles[0], b = mesh.triangles[1];
  const auto& p = mesh.positions;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (a[i] != b[(j + 1) % 3] || a[(i + 1) % 3] != b[j]) continue;
      const glm::vec3 normal = glm::cross(p[a.y] - p[a.x], p[a.z] - p[a.x]);
      const glm::vec3 other = glm::cross(p[b.y] - p[b.x], p[b.z] - p[b.x]);
      return glm::dot(normal, p[b[(j + 2) % 3]] - p[a.x]) == 0.0f && glm::dot(normal, other) > 0.0f;
    }
  return false;
}

template <typename Predicate>
bool any_instance(const model::Snapshot& snapshot, Predicate&& predicate) {
  return std::any_of(snapshot.instances.begin(), snapshot.instances.end(), predicate);
}

bool takes_inexact(const model::Snapshot& snapshot, const model::Instance& instance, sideray_inexact_target target) {
  return model::takes_inexact(snapshot.materials[instance.material], instance.wind, target);
}

uint64_t counted_surfaces(const model::Snapshot& snapshot, gl::TracedSet set) {
  const uint64_t surfaces = most_surfaces(snapshot, set, most_counted_surfaces);
  return surfaces < most_counted_surfaces ? surfaces : SIDERAY_UNBOUNDED;
}

void add_opaque(const model::Snapshot& snapshot, const model::Instance& instance, sideray_scene_facts& facts) {
  for (int target = SIDERAY_TARGET_MODEL; target <= SIDERAY_TARGET_STENCIL; ++target)
    facts.inexact_objects[target] +=
        takes_inexact(snapshot, instance, static_cast<sideray_inexact_target>(target)) ? 1 : 0;
  facts.glossy_objects += snapshot.materials[instance.material].mirrors ? 1 : 0;
}

}  // namespace

bool is_traced(const model::Snapshot& snapshot, const model::Instance& instance, gl::TracedSet set) {
  const model::Material& material = snapshot.materials[instance.material];
  if (set == gl::TracedSet::all_translucent) return material.translucent;
  return set == gl::TracedSet::visible_in_layers && material.traceable && instance.surface_id != 0 &&
         (instance.visibility & SIDERAY_VISIBLE_LAYERS);
}

bool has_traced(const model::Snapshot& snapshot, gl::TracedSet set) {
  return any_instance(snapshot, [&](const model::Instance& i) { return is_traced(snapshot, i, set); });
}

uint64_t most_surfaces(const model::Snapshot& snapshot, gl::TracedSet traced, uint64_t enough) {
  uint64_t surfaces = 0;
  for (const model::Instance& instance : snapshot.instances) {
    if (surfaces >= enough) return enough;
    if (!is_traced(snapshot, instance, traced)) continue;
    const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
    surfaces += instance.wind == 0 && is_flat_quad(mesh) ? 1 : mesh.triangles.size();
  }
  return std::min(surfaces, enough);
}

bool has_sprites(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.particles.begin(), snapshot.particles.end(),
                     [](const model::ParticleSystem& system) { return !system.sprites.empty(); });
}

uint64_t count_translucent(const model::Snapshot& snapshot) {
  return static_cast<uint64_t>(
      std::count_if(snapshot.instances.begin(), snapshot.instances.end(),
                    [&](const model::Instance& i) { return snapshot.materials[i.material].translucent; }));
}

bool is_lit(const model::Light& light) {
  return light.intensity != glm::vec3(0);
}

bool has_lit_light(const model::Snapshot& snapshot, size_t first) {
  return snapshot.lights.size() > first &&
         std::any_of(snapshot.lights.begin() + static_cast<ptrdiff_t>(first), snapshot.lights.end(), is_lit);
}

bool has_inexact(const model::Snapshot& snapshot, sideray_inexact_target target) {
  return any_instance(snapshot, [&](const model::Instance& i) { return takes_inexact(snapshot, i, target); });
}

bool has_tints(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.instances.begin(), snapshot.instances.end(), [&](const model::Instance& instance) {
    return model::tints_light(snapshot.materials[instance.material], instance);
  });
}

bool has_distortion(const model::Snapshot& snapshot) {
  return any_instance(snapshot, [&](const model::Instance& i) {
    const model::Material& material = snapshot.materials[i.material];
    return material.translucent && material.desc.distortion > 0.0f;
  });
}

sideray_scene_facts scene_facts(const model::Snapshot& snapshot) {
  sideray_scene_facts facts{};
  facts.size = sizeof(facts);
  facts.instances = snapshot.instances.size();
  facts.materials = snapshot.materials.size();
  std::map<uint32_t, uint64_t> swaying;  // instances of each mesh
  for (const model::Instance& instance : snapshot.instances) {
    facts.triangles += snapshot.meshes[instance.mesh]->triangles.size();
    facts.layered_objects += is_traced(snapshot, instance, gl::TracedSet::visible_in_layers) ? 1 : 0;
    if (snapshot.materials[instance.material].translucent) {
      ++facts.translucent_objects;
      facts.bending_objects += model::bends_light(snapshot.materials[instance.material].desc) ? 1 : 0;
      facts.traceable_objects += snapshot.materials[instance.material].traceable ? 1 : 0;
      continue;
    }
    add_opaque(snapshot, instance, facts);
    if (instance.wind == 0) continue;
    ++facts.swaying_objects;
    facts.swaying_copies = std::max(facts.swaying_copies, ++swaying[instance.mesh]);
  }
  facts.most_layers = counted_surfaces(snapshot, gl::TracedSet::visible_in_layers);
  facts.most_surfaces = counted_surfaces(snapshot, gl::TracedSet::all_translucent);
  for (const model::ParticleSystem& system : snapshot.particles) facts.sprites += system.sprites.size();
  facts.lit_lights = static_cast<uint64_t>(std::count_if(snapshot.lights.begin(), snapshot.lights.end(), is_lit));
  facts.has_environment = snapshot.environment->mean > 0.0f;
  const OpaqueRays chosen = opaque_rays_of(snapshot);
  facts.auto_ao = !chosen.why_no_ao;
  facts.auto_bounce = !chosen.why_no_bounce;
  facts.auto_reflections = !chosen.why_no_reflections;
  return facts;
}

}  // namespace sideray::bridge
