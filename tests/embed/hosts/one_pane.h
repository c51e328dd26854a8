// A scene of one pane and a view of it, for hosts that have nothing else to show. Test support; any thread.
#pragma once

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <sideray/sideray.hpp>

namespace sideray::tests {

inline constexpr uint32_t pane_id = 5;

// Returns an emissive pane of glass, 2 x 2, at z = 0.
inline sideray::Scene pane_scene() {
  constexpr float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  constexpr uint32_t indices[] = {0, 1, 2, 0, 2, 3};
  sideray::Scene scene = sideray::Scene::create().value();
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4, mesh.index_count = 6;
  mesh.positions.data = positions, mesh.indices = indices;
  sideray_material_desc material = sideray_material_defaults();
  material.alpha_mode = SIDERAY_BLEND;
  material.base_color[3] = 0.5f;
  material.emissive[0] = 0.25f;
  material.double_sided = 1;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(material);
  for (int i : {0, 4, 8}) instance.world_from_object[i] = 1.0;
  instance.surface_id = pane_id;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
  scene.commit();
  return scene;
}

// Returns clip space from world space, seen from (eye_x, 0, 3) toward -z.
inline glm::dmat4 clip_before_pane(double aspect, double eye_x = 0) {
  return glm::perspective(0.9, aspect, 0.1, 50.0) * glm::translate(glm::dmat4(1.0), glm::dvec3(-eye_x, 0, -3));
}

inline void set_matrices(sideray_view& view, const glm::dmat4& clip_from_world) {
  const glm::dmat4 world_from_clip = glm::inverse(clip_from_world);
  std::memcpy(view.clip_from_world, glm::value_ptr(clip_from_world), sizeof(view.clip_from_world));
  std::memcpy(view.world_from_clip, glm::value_ptr(world_from_clip), sizeof(view.world_from_clip));
}

}  // namespace sideray::tests
