// Tests which rays hit the backs of opaque surfaces that are not double sided (docs/adr/0043-back-faces.md).
#include <gtest/gtest.h>

#include "rt/refraction/refraction_scene.h"

namespace sideray::rt::back_faces_test {
namespace {

using namespace test;

constexpr glm::vec3 red{1, 0, 0}, green{0, 1, 0};

sideray_material_desc single_sided(sideray_material_desc m) {
  m.double_sided = 0;
  return m;
}

ReferenceImage trace(TestScene& scene, const TraceView& view, uint32_t bounces, uint32_t light_samples = 16) {
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  ReferenceRequest request;
  request.views = {view};
  request.width = request.height = 4;
  request.light_samples = light_samples;
  request.bounces = bounces;
  request.refraction = request.reflections = true;
  ReferenceImage image;
  tracer.trace_reference(request, image);
  return image;
}

glm::vec3 mean(const ReferenceImage& image) {
  glm::vec3 sum(0.0f);
  for (const glm::vec4& c : image.color) sum += glm::vec3(c);
  return sum / static_cast<float>(image.color.size());
}

// A red square that faces away along `toward`, and a green one behind it that faces back.
void add_red_before_green(TestScene& scene, float red_z, float green_z) {
  const float away = green_z > red_z ? 1.0f : -1.0f;
  scene.quad({0, 0, red_z}, {away * 9, 0, 0}, {0, 9, 0}, single_sided(glowing(red)));
  scene.quad({0, 0, green_z}, {-away * 9, 0, 0}, {0, 9, 0}, single_sided(glowing(green)));
}

const TraceView ahead = perspective({0, 0, 5}, {0, 0, 0}, 0.3, 1.0, 1e-3);
constexpr uint32_t one_or_all[] = {1, 0};

TEST(BackFaces, TheEyeLooksThroughThem) {
  TestScene scene;
  add_red_before_green(scene, 0, -2);
  for (const uint32_t bounces : one_or_all) {
    SCOPED_TRACE(bounces);
    EXPECT_EQ(mean(trace(scene, ahead, bounces)), green);
  }
}

// Also where many of them are in the way, and where one coincides with a front face.
TEST(BackFaces, ThoughTheyAreMany) {
  TestScene scene;
  for (int i = 0; i < 300; ++i) scene.quad({0, 0, 2 - 0.01f * static_cast<float>(i)}, {-9, 0, 0}, {0, 9, 0},
                                           single_sided(glowing(red)));
  scene.quad({0, 0, -2}, {-9, 0, 0}, {0, 9, 0}, single_sided(glowing(red)));
  scene.quad({0, 0, -2}, {9, 0, 0}, {0, 9, 0}, single_sided(glowing(green)));
  EXPECT_EQ(mean(trace(scene, ahead, 1)), green);
}

// Glass in front of them refracts the ray, which still counts as a primary ray.
TEST(BackFaces, TheEyeLooksThroughThemBehindGlass) {
  for (const float roughness : {0.0f, 0.3f}) {
    TestScene scene;
    add_red_before_green(scene, 0, -2);
    sideray_material_desc slab = solid_glass(1.5f);
    slab.roughness = roughness;
    Triangles::box({-9, -9, 2}, {9, 9, 2.5f}).add_to(scene, slab);
    for (const uint32_t bounces : one_or_all) {
      SCOPED_TRACE(bounces);
      const glm::vec3 seen = mean(trace(scene, ahead, bounces));
      EXPECT_GT(seen.y, 0.5f);
      EXPECT_LT(seen.x, bounces == 1 ? 1e-6f : 0.1f);  // what the slab's own faces mirror to each other
    }
  }
}

TEST(BackFaces, MirrorsShowThem) {
  TestScene scene;
  sideray_material_desc m = plain_material();
  m.metallic = 1.0f, m.roughness = 0.0f;
  scene.quad({0, 0, 0}, {9, 0, 0}, {0, 9, 0}, m);
  add_red_before_green(scene, 8, 10);
  for (const uint32_t bounces : one_or_all) {
    SCOPED_TRACE(bounces);
    const glm::vec3 seen = mean(trace(scene, ahead, bounces));
    EXPECT_NEAR(seen.x, 1.0f, 0.02f);
    EXPECT_LT(seen.y, 1e-6f);
  }
}

// A square over a floor, either side up: neither a lamp's light nor, along paths, the sky's comes through.
TEST(BackFaces, StopLight) {
  for (const bool up : {true, false}) {
    SCOPED_TRACE(up);
    for (const float radius : {0.0f, 0.1f}) {
      TestScene scene;
      scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, plain_material());
      scene.quad({0, 3, 0}, {0, 0, up ? 1.0f : -1.0f}, {1, 0, 0}, single_sided(plain_material()));
      sideray_light lamp = point_light({0, 6, 0}, 9.0f);
      lamp.radius = radius;
      scene.lights({lamp});
      const TraceView down = perspective({0, 2, 0}, {0, 0, 0}, 0.05, 1.0, 1e-3);
      EXPECT_EQ(mean(trace(scene, down, 1)), glm::vec3(0.0f));
    }
    TestScene scene;
    scene.environment(glm::vec3(1.0f));
    sideray_material_desc paper = plain_material();
    paper.specular = 0.0f, paper.base_color[0] = paper.base_color[1] = paper.base_color[2] = 0.5f;
    sideray_material_desc black = glowing(glm::vec3(0.0f));
    scene.quad({0, 0, 0}, {0, 0, 90}, {90, 0, 0}, paper);
    scene.quad({0, 1, 0}, {0, 0, up ? 1.0f : -1.0f}, {1, 0, 0}, single_sided(black));
    const TraceView down = perspective({0, 0.5, 0}, {0, 0, 0}, 0.05, 1.0, 1e-3);
    // The form factor of a square of half side 1 at distance 1, seen from below its middle.
    const double a = 1 / std::sqrt(2.0), covered = 4 * 2 * a * std::atan(a) / (2 * M_PI);
    EXPECT_NEAR(mean(trace(scene, down, 2, 1024)).y, 0.5 * (1 - covered), 0.01);
  }
}

}  // namespace
}  // namespace sideray::rt::back_faces_test
