#include <gtest/gtest.h>

#include "model/scene.h"
#include "rt/embree/intersector.h"

namespace sideray::rt {
namespace {

// 16-wide coherent occlusion of instances reads uninitialised stack in Embree 3.13.5 and may never return.
TEST(Occlusion, CoherentCallsReturnAfterIncoherentOnes) {
  model::Scene scene;
  const float positions[] = {-3, 0, -3, 3, 0, -3, 3, 0, 3, -3, 0, 3};
  const uint32_t indices[] = {0, 2, 1, 0, 3, 2};
  sideray_mesh_desc mesh{};
  mesh.size = sizeof(mesh);
  mesh.vertex_count = 4;
  mesh.positions.data = positions;
  mesh.index_count = 6;
  mesh.indices = indices;
  scene.add_mesh(mesh, nullptr);
  sideray_material_desc material{};
  material.ior = material.attenuation_distance = 1.5f;
  scene.add_material(material);
  sideray_instance_desc instance{};
  instance.mesh = instance.material = instance.surface_id = 1;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  for (int i : {0, 4, 8}) instance.world_from_object[i] = 1.0;
  scene.add_instances(&instance, 1);
  scene.commit();
  Intersector intersector("");
  intersector.set_scene(scene.snapshot());
  std::vector<Ray> rays;
  for (int i = 0; i < 32; ++i)
    rays.push_back({{0.1f * static_cast<float>(i % 8), 1.0f, 0.0f}, 0.0f, {0, i < 16 ? -1.0f : 1.0f, 0}, 100.0f});
  std::vector<uint8_t> occluded(rays.size());
  for (const bool coherent : {false, true, false, true}) {
    intersector.occluded(rays, coherent, occluded.data());
    for (size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(occluded[i], i < 16 ? 1 : 0) << i;
  }
}

}  // namespace
}  // namespace sideray::rt
