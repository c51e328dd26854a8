#include "model/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

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

TEST(Scene, TakesIndicesOf16BitsAndColoursOfBytes) {
  struct Vertex {
    float position[3];
    uint8_t color[4];
  };
  const Vertex vertices[] = {{{0, 0, 0}, {255, 0, 51, 102}}, {{1, 0, 0}, {0, 0, 0, 255}}, {{0, 1, 0}, {0, 0, 0, 255}},
                             {{1, 1, 0}, {0, 0, 0, 255}}};
  const uint16_t indices[] = {0, 1, 2, 2, 1, 3};
  sideray_mesh_desc d = triangle(vertices[0].position, 4);
  d.positions.stride_bytes = sizeof(Vertex);
  d.index_count = 6, d.short_indices = indices;
  d.color_bytes = vertices[0].color, d.color_bytes_stride = sizeof(Vertex);
  const float normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  d.normals.data = normals;
  Scene scene;
  scene.add_mesh(d, nullptr);
  d.color_bytes_bgra = 1;
  scene.add_mesh(d, nullptr);
  scene.commit();
  const auto meshes = scene.snapshot()->meshes;
  EXPECT_EQ(meshes[0]->triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {2, 1, 3}}));
  EXPECT_TRUE(meshes[0]->has_colors);
  EXPECT_EQ(meshes[0]->colors[0], glm::vec4(1, 0, 0.2f, 0.4f));
  EXPECT_EQ(meshes[1]->colors[0], glm::vec4(0.2f, 0, 1, 0.4f));
  EXPECT_FLOAT_EQ(meshes[0]->minimum_alpha, 0.4f);
  const uint32_t both[] = {0, 1, 2, 2, 1, 3};
  d.indices = both;
  EXPECT_THROW(scene.add_mesh(d, nullptr), Failure);
  d.indices = nullptr, d.color_bytes_stride = 3;
  EXPECT_THROW(scene.add_mesh(d, nullptr), Failure);
  d.color_bytes_stride = sizeof(Vertex), d.colors.data = normals;
  EXPECT_THROW(scene.add_mesh(d, nullptr), Failure);
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
  const std::pair<float sideray_material_desc::*, std::vector<float>> films[] = {
      {&sideray_material_desc::anisotropy, {-0.1f, 1.1f, NAN}},
      {&sideray_material_desc::anisotropy_rotation, {NAN, INFINITY, -INFINITY}},
      {&sideray_material_desc::iridescence, {-0.1f, 1.1f, NAN}},
      {&sideray_material_desc::iridescence_ior, {0.9f, 0.0f, INFINITY, NAN}},
      {&sideray_material_desc::iridescence_thickness_min, {-1.0f, INFINITY, NAN}},
      {&sideray_material_desc::iridescence_thickness_max, {-1.0f, INFINITY, NAN}}};
  for (const auto& [field, values] : films)
    for (const float value : values) {
      material = white();
      material.iridescence = 1.0f, material.iridescence_ior = 1.3f;
      material.*field = value;
      EXPECT_THROW(scene.add_material(material), Failure) << value;
    }
  for (const float dispersion : {-1.0f, NAN, INFINITY}) {
    material = white();
    material.dispersion = dispersion;
    EXPECT_THROW(scene.add_material(material), Failure);
  }
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

std::string refusal_of(Scene& scene, uint32_t mesh, const sideray_mesh_desc& desc) {
  try {
    scene.set_vertices(mesh, desc);
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_INVALID_ARGUMENT);
    return failure.what();
  }
  return "";
}

TEST(Vertices, SnapshotsStayAndTrianglesTooAndBoundsFollow) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  // The second triangle is dropped, the third is not.
  const float before[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, nan, 0, 0, 1, 2, 0, 2, 1, 0};
  const float after[] = {0, 0, 3, 2, 0, 3, 0, 2, 3, 9, 9, 9, 5, 2, 3, 2, 5, 3};
  const uint32_t indices[] = {0, 1, 2, 3, 4, 5, 1, 4, 5};
  for (const bool smooth : {false, true}) {
    const std::vector<float> normals{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    const auto desc = [&](const float* positions) {
      sideray_mesh_desc d = triangle(positions, 6);
      d.indices = indices, d.index_count = 9;
      if (smooth) d.normals.data = normals.data();
      return d;
    };
    Scene scene;
    scene.add_mesh(desc(before), nullptr);
    scene.add_material(white());
    const sideray_instance_desc instance = instance_at(0);
    scene.add_instances(&instance, 1);
    scene.commit();
    const auto first = scene.snapshot();
    const Mesh copy = *first->meshes[0];
    sideray_mesh_desc moved = desc(after);
    moved.indices = nullptr, moved.index_count = 0;  // not read
    scene.set_vertices(1, moved);
    EXPECT_EQ(scene.snapshot(), first) << "until the commit";
    scene.commit();
    const auto second = scene.snapshot();
    EXPECT_EQ(first->meshes[0]->positions, copy.positions);
    const Mesh& mesh = *second->meshes[0];
    EXPECT_NE(first->meshes[0], second->meshes[0]);
    EXPECT_EQ(mesh.triangles, copy.triangles);
    EXPECT_EQ(mesh.source_primitive, (std::vector<uint32_t>{0, 2}));
    EXPECT_TRUE(same_triangles(mesh, copy));
    EXPECT_EQ(mesh.positions[mesh.triangles[1].z], glm::vec3(2, 5, 3));
    EXPECT_EQ(mesh.normals[mesh.triangles[0].x], glm::vec3(0, 0, 1));
    EXPECT_EQ(mesh.bounds.minimum, glm::vec3(0, 0, 3));
    EXPECT_EQ(mesh.bounds.maximum, glm::vec3(5, 5, 3));
    EXPECT_EQ(second->instances[0].bounds.maximum, glm::vec3(5, 5, 3));
  }
}

TEST(Vertices, FlatNormalsTurnAlongAndSurviveNoArea) {
  const float flat[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, turned[] = {0, 0, 0, 1, 0, 0, 0, 0, 1},
              nothing[] = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  Scene scene;
  scene.add_mesh(triangle(flat, 3), nullptr);
  scene.set_vertices(1, triangle(turned, 3));
  scene.commit();
  EXPECT_EQ(scene.snapshot()->meshes[0]->normals[0], glm::vec3(0, -1, 0));
  scene.set_vertices(1, triangle(nothing, 3));
  scene.commit();
  EXPECT_EQ(scene.snapshot()->meshes[0]->triangles.size(), 1u);
  EXPECT_EQ(scene.snapshot()->meshes[0]->normals[0], glm::vec3(0, 0, 1));
  scene.set_vertices(1, triangle(flat, 3));
  scene.commit();
  EXPECT_EQ(scene.snapshot()->meshes[0]->positions[2], glm::vec3(0, 1, 0));
}

TEST(Vertices, RefusedOnesChangeNothing) {
  const float good[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, far[] = {0, 0, 0, 1, 0, 0, 0, 2e15f, 0},
              broken[] = {0, 0, 0, NAN, 0, 0, 0, 1, 0};
  Scene scene;
  scene.add_mesh(triangle(good, 3), nullptr);
  EXPECT_NE(refusal_of(scene, 0, triangle(good, 3)), "");
  EXPECT_NE(refusal_of(scene, 2, triangle(good, 3)), "");
  EXPECT_NE(refusal_of(scene, 1, triangle(good, 2)).find("3 vertices"), std::string::npos);
  EXPECT_NE(refusal_of(scene, 1, triangle(nullptr, 3)), "");
  EXPECT_NE(refusal_of(scene, 1, triangle(far, 3)).find("vertex 2"), std::string::npos);
  EXPECT_NE(refusal_of(scene, 1, triangle(broken, 3)).find("vertex 1"), std::string::npos);
  sideray_mesh_desc with_normals = triangle(good, 3);
  with_normals.normals.data = good;
  EXPECT_NE(refusal_of(scene, 1, with_normals).find("normals"), std::string::npos);
  scene.commit();
  EXPECT_EQ(scene.snapshot()->meshes[0]->positions[1], glm::vec3(1, 0, 0));
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
