#include "model/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "model/failure.h"

namespace sideray::model {
namespace {

sideray_mesh_desc triangle(const float* positions, uint32_t vertices) {
  sideray_mesh_desc d{};
  d.size = sizeof(d);
  d.vertex_count = vertices;
  d.positions.data = positions;
  return d;
}

sideray_material_desc white() {
  sideray_material_desc d{};
  d.size = sizeof(d);
  for (float& c : d.base_color) c = 1;
  d.ior = 1.5f;
  d.attenuation_distance = INFINITY;
  return d;
}

sideray_instance_desc instance_at(double x) {
  sideray_instance_desc d{};
  d.mesh = d.material = 1;
  d.surface_id = 1;
  d.visibility = SIDERAY_VISIBLE_ALL;
  d.world_from_object[0] = d.world_from_object[4] = d.world_from_object[8] = 1;
  d.world_from_object[9] = x;
  return d;
}

TEST(Scene, DropsUnusableTrianglesAndKeepsTheirNumbering) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float positions[] = {0, 0, 0, 1, 0, 0, nan, 1, 0,   // not finite
                             0, 0, 0, 1, 0, 0, 2,   0, 0,   // no area
                             0, 0, 0, 1, 0, 0, 0,   1, 0};  // good
  Scene scene;
  uint32_t dropped = 0;
  scene.add_mesh(triangle(positions, 9), &dropped);
  scene.add_material(white());
  const sideray_instance_desc d = instance_at(0);
  scene.add_instances(&d, 1);
  scene.commit();
  const Mesh& mesh = *scene.snapshot()->meshes[0];
  EXPECT_EQ(dropped, 2u);
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.source_primitive, std::vector<uint32_t>{2});
  EXPECT_EQ(mesh.normals[mesh.triangles[0].x], glm::vec3(0, 0, 1));
  for (const glm::vec3& p : mesh.positions) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
}

TEST(Scene, LocalPositionsStayPreciseFarFromTheOrigin) {
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  Scene scene;
  scene.add_mesh(triangle(positions, 3), nullptr);
  scene.add_material(white());
  const sideray_instance_desc d[] = {instance_at(1e6 + 0.125), instance_at(1e6 + 1.0)};
  scene.add_instances(d, 2);
  scene.commit();
  const auto snapshot = scene.snapshot();
  const double x = snapshot->origin.x + double{snapshot->instances[0].local_from_object[3].x};
  EXPECT_NEAR(x, 1e6 + 0.125, 1e-4);
  EXPECT_LT(std::abs(snapshot->instances[0].local_from_object[3].x), 1024.0f);
}

TEST(Scene, RefusesWhatWouldHarm) {
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  Scene scene;
  sideray_mesh_desc mesh = triangle(positions, 3);
  const uint32_t indices[] = {0, 1, 7};
  mesh.indices = indices;
  mesh.index_count = 3;
  EXPECT_THROW(scene.add_mesh(mesh, nullptr), Failure);
  scene.add_mesh(triangle(positions, 3), nullptr);
  sideray_material_desc material = white();
  material.roughness = NAN;
  EXPECT_THROW(scene.add_material(material), Failure);
  material = white();
  material.base_color_texture.texture = 1;
  EXPECT_THROW(scene.add_material(material), Failure);
  scene.add_material(white());
  sideray_instance_desc d[] = {instance_at(0), instance_at(NAN)};
  EXPECT_THROW(scene.add_instances(d, 2), Failure);
  d[1] = instance_at(0);
  d[1].world_from_object[0] = 0;
  EXPECT_THROW(scene.add_instances(d, 2), Failure);
  scene.commit();
  EXPECT_TRUE(scene.snapshot()->instances.empty()) << "a refused call must change nothing";
}

TEST(Texture, MipLevelsAverageInLinearLight) {
  const uint8_t texels[] = {0, 0, 0, 0, 255, 255, 255, 255, 0, 0, 0, 0, 255, 255, 255, 255};
  Scene scene;
  scene.add_texture(2, 2, SIDERAY_RGBA8_SRGB, texels);
  scene.add_texture(2, 2, SIDERAY_RGBA8, texels);
  scene.commit();
  const auto& textures = scene.snapshot()->textures;
  EXPECT_EQ(textures[0]->levels[1].rgba[0], 188);  // sRGB code of linear 0.5
  EXPECT_EQ(textures[1]->levels[1].rgba[0], 128);
  EXPECT_EQ(textures[0]->levels[1].rgba[3], 128);  // alpha is never sRGB
  EXPECT_EQ(textures[0]->minimum_alpha, 0);
}

}  // namespace
}  // namespace sideray::model
