// Compares the mean of rough reflections with quadrature over the microfacets, and tests that smooth surfaces use no
// random numbers.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rt/base/sampling.h"
#include "rt/shading/hit_shader.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

constexpr float wall_size = 500.0f;

bool sees_wall(glm::dvec3 direction) {
  const glm::dvec3 at = direction / direction.z;
  return at.x > 0 && at.x < 2.0 * static_cast<double>(wall_size) && std::abs(at.y) < static_cast<double>(wall_size);
}

// A mirror at z = 0 that looks along +z, before it a glowing wall at z = 1 that covers nearly all directions with x >
// 0.
struct HalfWall {
  explicit HalfWall(sideray_material_desc material, float roughness) {
    material.roughness = roughness;
    TestScene scene;
    scene.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, material);
    scene.quad({wall_size, 0, 1}, {0, wall_size, 0}, {wall_size, 0, 0}, glowing(glm::vec3(1.0f)));
    shading = std::make_unique<ShadingScene>(scene.commit());
    intersector.set_scene(shading->snapshot);
  }

  SurfacePoint point(glm::vec3 to_eye) const {
    Hit hit{};
    hit.u = 0.0f, hit.v = 0.5f;  // the middle of the quad
    hit.front = true, hit.distance = 1.0;
    return surface_point(*shading, hit, {to_eye, 0.0f, -to_eye, 1e30f}, {});
  }

  std::vector<float> radiance(glm::vec3 to_eye, uint32_t keys) {
    std::vector<SurfacePoint> points(keys, point(to_eye));
    for (uint32_t i = 0; i < keys; ++i) points[i].key = random_key({7, i});
    HitShader shader;
    shader.begin(*shading, intersector);
    std::vector<glm::vec3> result(keys);
    shader.shade(points, result.data());
    std::vector<float> red;
    for (const glm::vec3& c : result) red.push_back(c.x);
    return red;
  }

  std::unique_ptr<ShadingScene> shading;
  Intersector intersector{""};
};

sideray_material_desc white_metal() {
  sideray_material_desc m = blended(glm::vec3(1.0f), 1.0f);
  m.metallic = 1.0f;
  return m;
}

struct Share {
  double wall, all;
};

// Of the visible microfacets whose reflections leave the surface: how many see the wall. Midpoints over the slopes'
// polar coordinates, with tan(theta) = alpha t / sqrt(1 - t^2): uniform in what GGX distributes.
Share visible_share(glm::dvec3 to_eye, double alpha) {
  constexpr int radial = 600, around = 600;
  Share share{0.0, 0.0};
  for (int i = 0; i < radial; ++i)
    for (int k = 0; k < around; ++k) {
      const double rest = 1 - (i + 0.5) / radial, u = 1 - rest * rest;  // finer where the tail is long
      const double azimuth = 2 * M_PI * (k + 0.5) / around;
      const double tangent = alpha * std::sqrt(u / (1 - u));
      const glm::dvec3 h = glm::normalize(glm::dvec3(tangent * std::cos(azimuth), tangent * std::sin(azimuth), 1));
      // Equal shares of D(h) h.z; visible: times max(v.h, 0) / h.z.
      const double weight = 2 * rest * std::max(glm::dot(to_eye, h), 0.0) / h.z;
      const glm::dvec3 l = 2 * glm::dot(to_eye, h) * h - to_eye;
      if (l.z <= 0) continue;
      share.all += weight;
      if (sees_wall(l)) share.wall += weight;
    }
  return share;
}

TEST(RoughReflection, means_what_the_visible_microfacets_see) {
  constexpr uint32_t keys = 5000;
  for (const float roughness : {0.1f, 0.3f, 0.6f, 1.0f})
    for (const glm::vec3 direction :
         {glm::vec3(0, 0, 1), glm::vec3(0.1f, 0.2f, 1), glm::vec3(-1, 0, 1), glm::vec3(2, 1, 1)}) {
      const glm::vec3 to_eye = glm::normalize(direction);
      HalfWall scene(white_metal(), roughness);
      const std::vector<float> seen = scene.radiance(to_eye, keys);
      const Share share = visible_share(glm::dvec3(to_eye), static_cast<double>(roughness * roughness));
      const double expected = share.wall / share.all;
      double sum = 0;
      for (const float s : seen) {
        // Every direction shows the wall or nothing, and what is reflected more than once is not lost.
        EXPECT_TRUE(s == 0.0f || std::abs(s - 1.0f) < 1e-4f) << s;
        sum += static_cast<double>(s);
      }
      const double error = std::sqrt(std::max(expected * (1 - expected), 1e-4) / keys);
      EXPECT_NEAR(sum / keys, expected, 4 * error) << roughness << ' ' << direction.x << ' ' << direction.y;
    }
}

// The coat over a black base, sampled by numbers of its own.
TEST(RoughReflection, coats_are_rough_too) {
  constexpr uint32_t keys = 5000;
  sideray_material_desc m = blended(glm::vec3(0), 1.0f);
  m.specular = 0.0f, m.clearcoat = 1.0f, m.clearcoat_roughness = 0.5f;
  HalfWall scene(m, 1.0f);
  const glm::vec3 to_eye = glm::normalize(glm::vec3(0.3f, 0.1f, 1.0f));
  const double share = static_cast<double>(scene.point(to_eye).surface.coat_share);
  const Share visible = visible_share(glm::dvec3(to_eye), 0.25);
  const double expected = visible.wall / visible.all;
  double sum = 0;
  for (const float s : scene.radiance(to_eye, keys)) sum += static_cast<double>(s) / share;
  EXPECT_NEAR(sum / keys, expected, 4 * std::sqrt(expected * (1 - expected) / keys));
}

TEST(RoughReflection, leaves_mirrors_alone) {
  for (const float roughness : {0.0f, 0.04f}) {
    HalfWall scene(white_metal(), roughness);
    const std::vector<float> seen = scene.radiance(glm::normalize(glm::vec3(-0.01f, 0, 1)), 64);
    EXPECT_THAT(seen, testing::Each(seen[0]));
    EXPECT_GT(seen[0], 0.9f);
  }
}

// At the edge of the wall rays of a lobe hit it randomly, unless the lobe is narrow and faint: then the mirror
// direction replaces it, and nothing is marked for the filter.
TEST(RoughReflection, has_no_noise_where_narrow_and_faint) {
  const auto tells_rough = [](const HalfWall& scene, glm::vec3 to_eye) {
    HitShader shader;
    shader.begin(*scene.shading, scene.intersector, {.tell_rough = true});
    const SurfacePoint point = scene.point(to_eye);
    glm::vec3 radiance;
    shader.shade({&point, 1}, &radiance);
    return shader.rough()[0].weight != glm::vec3(0.0f);
  };
  sideray_material_desc plain = blended(glm::vec3(0), 1.0f), coated = plain;
  coated.specular = 0.0f, coated.clearcoat = 1.0f;
  const glm::vec3 head_on = glm::normalize(glm::vec3(-0.0005f, 0, 1));
  const glm::vec3 glancing = glm::normalize(glm::vec3(-0.0005f, 5, 1));
  for (sideray_material_desc material : {plain, coated})
    for (const float roughness : {0.08f, 0.1f, 0.12f})
      for (const glm::vec3 to_eye : {head_on, glancing}) {
        const bool is_narrow = roughness <= 0.1f && to_eye == head_on;
        material.clearcoat_roughness = roughness;
        HalfWall scene(material, roughness);
        const std::vector<float> seen = scene.radiance(to_eye, 64);
        const float most = std::ranges::max(seen);
        EXPECT_GT(most, 0.0f);
        EXPECT_EQ(std::ranges::count(seen, most) == 64, is_narrow) << roughness << ' ' << to_eye.y;
        EXPECT_EQ(tells_rough(scene, to_eye), !is_narrow) << roughness << ' ' << to_eye.y;
      }
}

// Nothing stands around: the prefiltered sky, as the rasterizer has it, without any noise.
TEST(RoughReflection, of_the_sky_alone_has_no_noise) {
  TestScene scene;
  sideray_material_desc m = white_metal();
  m.roughness = 0.7f;
  scene.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, m);
  scene.environment({0.5f, 1, 2});
  const ShadingScene shading(scene.commit());
  Intersector intersector("");
  intersector.set_scene(shading.snapshot);
  Hit hit{};
  hit.v = 0.5f, hit.front = true, hit.distance = 1.0;
  std::vector<SurfacePoint> points(64, surface_point(shading, hit, {{0, 0, 1}, 0.0f, {0, 0, -1}, 1e30f}, {}));
  for (uint32_t i = 0; i < points.size(); ++i) points[i].key = i;
  HitShader shader;
  shader.begin(shading, intersector);
  std::vector<glm::vec3> radiance(points.size());
  shader.shade(points, radiance.data());
  EXPECT_THAT(radiance, testing::Each(radiance[0]));
}

}  // namespace
}  // namespace sideray::rt
