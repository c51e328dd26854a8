// Small scenes and a context for the tests of the rasterizer.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <vector>

#include "gl/context/context.h"
#include "gl/rasterizer.h"
#include "model/material.h"
#include "model/material_slots.h"
#include "model/scene.h"

namespace sideray::gl::tests {

inline sideray_material_desc plain_material() {
  return model::default_material();
}

// Leaves the surface as its base colour, whatever the light.
inline sideray_material_desc unlit(glm::vec4 color, sideray_alpha_mode mode = SIDERAY_OPAQUE) {
  sideray_material_desc d = plain_material();
  for (int c = 0; c < 4; ++c) d.base_color[c] = color[c];
  d.alpha_mode = mode;
  d.unlit = 1;
  return d;
}

inline sideray_camera camera_at(glm::dvec3 eye, glm::dvec3 target = glm::dvec3(0)) {
  sideray_camera camera{};
  camera.size = sizeof(camera);
  const glm::dvec3 back = glm::normalize(eye - target);
  const glm::dvec3 hint = std::abs(back.y) < 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, -1);
  const glm::dvec3 right = glm::normalize(glm::cross(hint, back)), up = glm::cross(back, right);
  const glm::dvec3 columns[4] = {right, up, back, eye};
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) camera.world_from_camera[3 * c + r] = columns[c][r];
  camera.yfov = 0.9f;
  camera.z_near = 0.1f;
  return camera;
}

// Wind that moves trunk, branches and leaves.
inline sideray_wind_desc breeze() {
  sideray_wind_desc d{};
  d.size = sizeof(d);
  d.direction[0] = 0.6f, d.direction[2] = 0.8f;
  d.amplitude = 0.5f, d.frequency = 0.4f, d.height = 2;
  d.branch_amplitude = 0.2f, d.branch_frequency = 0.9f;
  d.leaf_amplitude = 0.05f, d.leaf_frequency = 2.1f;
  d.wavelength = 1.5f;
  return d;
}

// A model::Scene with quads: corners (-1,-1,0)..(1,1,0), facing +Z, uv (0,0) at the top left.
class SceneBuilder {
 public:
  SceneBuilder() {
    const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    const float normals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    const float uvs[] = {0, 1, 1, 1, 1, 0, 0, 0};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    sideray_mesh_desc d{};
    d.size = sizeof(d);
    d.vertex_count = 4;
    d.index_count = 6;
    d.indices = indices;
    d.positions.data = positions;
    d.normals.data = normals;
    d.uv0.data = uvs;
    quad_ = scene.add_mesh(d, nullptr);
  }

  uint32_t material(const sideray_material_desc& d) { return scene.add_material(d); }

  void quad(uint32_t material_index, const glm::dmat4& world_from_object, uint32_t surface_id = 1,
            uint32_t visibility = SIDERAY_VISIBLE_ALL) {
    sideray_instance_desc d{};
    d.mesh = quad_;
    d.material = material_index;
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) d.world_from_object[3 * c + r] = world_from_object[c][r];
    d.surface_id = surface_id;
    d.visibility = visibility;
    scene.add_instances(&d, 1);
  }
  void quad(uint32_t material_index, glm::dvec3 center, double size = 1, uint32_t surface_id = 1) {
    quad(material_index, glm::scale(glm::translate(glm::dmat4(1), center), glm::dvec3(size)), surface_id);
  }

  void sky(glm::vec3 radiance) {
    std::vector<glm::vec3> texels(32 * 16, radiance);
    scene.set_environment(32, 16, &texels[0].x, 1.0f, 0.0f);
  }

  std::shared_ptr<const model::Snapshot> commit() {
    scene.commit();
    return scene.snapshot();
  }

  model::Scene scene;

 private:
  uint32_t quad_ = 0;
};

struct RasterTest : ::testing::Test {
  static void SetUpTestSuite() { context = Context::create("auto", ""); }
  static void TearDownTestSuite() { context.reset(); }
  void SetUp() override {
    ASSERT_NE(context, nullptr) << "no OpenGL context: see what SetUpTestSuite reported";
    rasterizer = std::make_unique<Rasterizer>(context->functions());
  }
  void TearDown() override {
    if (!context) return;
    rasterizer.reset();
    EXPECT_EQ(context->functions().GetError(), unsigned{GL_NO_ERROR});
    for (const std::string& message : context->take_errors()) ADD_FAILURE() << "OpenGL: " << message;
  }

  // Draws everything up to and including light().
  RasterView draw_opaque(const std::shared_ptr<const model::Snapshot>& snapshot, const sideray_camera& camera,
                         bool shadows = false, glm::vec2 jitter = glm::vec2(0)) {
    rasterizer->set_scene(snapshot);
    rasterizer->resize(width, height);
    const RasterView view = rasterizer->make_view(camera, jitter);
    rasterizer->set_view(view);
    rasterizer->gbuffer();
    if (shadows) rasterizer->shadow_maps();
    rasterizer->light(shadows);
    return view;
  }
  size_t pixel(uint32_t x, uint32_t y) const { return size_t{y} * width + x; }
  size_t middle() const { return pixel(width / 2, height / 2); }

  static inline std::unique_ptr<Context> context;
  std::unique_ptr<Rasterizer> rasterizer;
  uint32_t width = 96, height = 64;
};

inline void expect_near(glm::vec4 actual, glm::vec4 expected, float tolerance) {
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(actual[c], expected[c], tolerance) << "channel " << c;
}

}  // namespace sideray::gl::tests
