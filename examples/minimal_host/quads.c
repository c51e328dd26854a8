#include "quads.h"

#include "engine.h"

void sideray_require(sideray_status status, const sideray_error* error) {
  require(status == SIDERAY_OK, error->message);
}

void add_quad(sideray_scene* scene, int quad, const sideray_material_desc* desc, uint32_t surface_id) {
  uint32_t own[6];
  for (int i = 0; i < 6; ++i) own[i] = indices[6 * quad + i] - 4u * (uint32_t)quad;
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4;
  mesh.positions.data = positions + 12 * quad;
  mesh.index_count = 6;
  mesh.indices = own;
  sideray_instance_desc instance = {0};
  sideray_error error;
  sideray_require(sideray_scene_add_mesh(scene, &mesh, &instance.mesh, NULL, &error), &error);
  sideray_require(sideray_scene_add_material(scene, desc, &instance.material, &error), &error);
  for (int i = 0; i < 3; ++i) instance.world_from_object[4 * i] = 1.0;
  instance.surface_id = surface_id;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  sideray_require(sideray_scene_add_instances(scene, &instance, sizeof(instance), 1, NULL, &error), &error);
}
