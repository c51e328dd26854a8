// Compares bounced light at hits of rays with closed forms: a furnace, an open field, half a sky.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "rt/shading/hit_shader.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::light_around_test {
namespace {

using namespace test;

// Shades the hits of rays from a point through a grid on a face of a cube.
struct Hits {
  explicit Hits(TestScene& scene) : shading(std::make_unique<ShadingScene>(scene.commit())) {
    intersector.set_scene(shading->snapshot);
  }

  std::vector<glm::vec3> shade(glm::vec3 from, glm::vec3 toward, bool bounces, uint32_t position = 0) {
    std::vector<Ray> rays;
    add_rays(from, toward, rays);
    return shade(rays, bounces, position);
  }

  static void add_rays(glm::vec3 from, glm::vec3 toward, std::vector<Ray>& rays) {
    constexpr int side = 24;
    const glm::vec3 across = glm::abs(toward.y) > 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const float u = (static_cast<float>(x) + 0.5f) / side - 0.5f, v = (static_cast<float>(y) + 0.5f) / side - 0.5f;
        rays.push_back({from, 0.0f, glm::normalize(toward + u * across + v * glm::cross(toward, across)), 1e30f});
      }
  }

  std::vector<glm::vec3> shade(const std::vector<Ray>& rays, bool bounces, uint32_t position = 0) {
    std::vector<Hit> hits(rays.size());
    intersector.nearest_opaque(rays, {}, hits.data());
    std::vector<HitPlace> places;
    for (size_t i = 0; i < rays.size(); ++i)
      if (hits[i].instance != no_instance) places.push_back({&hits[i], &rays[i], {0.0f, 0.02f}, weight});
    std::vector<glm::vec3> radiance(places.size());
    HitShader shader;
    shader.begin(*shading, intersector, {.bounces = bounces ? std::optional<uint32_t>(position) : std::nullopt});
    shader.shade_secondary_hits(places, radiance.data());
    rays_bounce = shader.rays_bounce;
    return radiance;
  }

  std::unique_ptr<ShadingScene> shading;
  Intersector intersector{""};
  float weight = 1.0f;  // of each hit in its pixel
  uint64_t rays_bounce = 0;
};

glm::vec3 mean(const std::vector<glm::vec3>& values) {
  glm::vec3 sum(0.0f);
  for (const glm::vec3 v : values) sum += v;
  return sum / static_cast<float>(values.size());
}

// Adds a floor beside a bright wall.
void add_floor_and_wall(TestScene& scene) {
  scene.quad({0, -2, 0}, {50, 0, 0}, {0, 0, 50}, matt(0.5f));
  scene.quad({4, 0, 0}, {0, 2, 0}, {0, 0, 50}, matt(0.7f, glm::vec3(1.0f, 0.5f, 0.2f)));
  scene.environment(glm::vec3(1.0f));
}

// Everywhere in the furnace the light is e + a e + a^2 e + ... = e / (1 - a), without any of the sky outside.
TEST(LightAround, OfAFurnaceHasAllBounces) {
  for (const float albedo : {0.0f, 0.5f, 0.8f}) {
    const glm::vec3 emission(0.5f, 0.25f, 0.125f);
    TestScene scene;
    const sideray_material_desc m = matt(albedo, emission);
    for (const double s : {-1.0, 1.0}) {
      scene.quad({8 * s, 0, 0}, {0, 2, 0}, {0, 0, 8}, m);
      scene.quad({0, 2 * s, 0}, {8, 0, 0}, {0, 0, 8}, m);
      scene.quad({0, 0, 8 * s}, {8, 0, 0}, {0, 2, 0}, m);
    }
    scene.environment(glm::vec3(3.0f));
    Hits hits(scene);
    glm::vec3 found(0.0f);
    constexpr uint32_t positions = 16;
    for (uint32_t i = 0; i < positions; ++i)
      found += mean(hits.shade({0, 0, 0.1f}, {0, -1, 0}, true, i)) / static_cast<float>(positions);
    const glm::vec3 expected = emission / (1.0f - albedo);
    EXPECT_GT(hits.rays_bounce, 0u);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.03f * expected[c]) << albedo;
    const glm::vec3 without = mean(hits.shade({0, 0, 0}, {0, -1, 0}, false));
    EXPECT_EQ(hits.rays_bounce, 0u);
    EXPECT_NEAR(without.x, emission.x + 3.0f * albedo, 1e-3f) << "all of the sky, and nothing of the walls";
  }
}

// The sky is fully open, so the light equals the sky's to the bit.
TEST(LightAround, OfAnOpenFieldIsTheSky) {
  TestScene scene;
  scene.quad({0, -2, 0}, {500, 0, 0}, {0, 0, 500}, matt(0.8f));
  scene.environment({1.0f, 0.5f, 0.25f});
  Hits hits(scene);
  const std::vector<glm::vec3> with = hits.shade({0, 0, 0}, {0, -1, 0}, true), without = hits.shade({0, 0, 0}, {0, -1, 0}, false);
  EXPECT_EQ(with, without);
}

// An endless black ceiling covers half of the sky, so half of its light is left.
TEST(LightAround, OfHalfASkyIsHalf) {
  TestScene scene;
  scene.quad({0, -2, 0}, {50, 0, 0}, {0, 0, 50}, matt(0.5f));
  scene.quad({5000, 8, 0}, {5000, 0, 0}, {0, 0, 5000}, matt(0.0f));
  scene.environment({2.0f, 1.0f, 0.5f});
  Hits hits(scene);
  // Straight below the edge the covered half of the directions carries half of the light.
  constexpr int places = 16;
  glm::vec3 found(0.0f), all(0.0f);
  for (int i = 0; i < places; ++i) {
    const glm::vec3 eye(0.0f, -1.5f, 0.5f * static_cast<float>(i));
    found += mean(hits.shade(eye, {0, -1, 0}, true));
    all += mean(hits.shade(eye, {0, -1, 0}, false));
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], 0.5f * all[c], 0.02f * all[c]);
}

// Returns the share of the light that the quarter of a parallel rectangle hides whose corner is straight above.
double hidden_by_quarter(double across, double along) {
  const double a = std::sqrt(1.0 + across * across), b = std::sqrt(1.0 + along * along);
  return (across / a * std::atan(along / a) + along / b * std::atan(across / b)) / (2.0 * M_PI);
}

// A black square low above a floor: the bright floor around does not brighten what lies below the square.
TEST(LightAround, BelowAnObjectIsDark) {
  constexpr double half = 1.0, height = 0.4;
  TestScene scene;
  sideray_material_desc black = matt(0.0f);
  black.specular = 0.0f;
  sideray_material_desc floor = matt(0.5f);
  floor.specular = 0.0f;
  scene.quad({0, -2, 0}, {50, 0, 0}, {0, 0, 50}, floor);
  scene.quad({0, height - 2, 0}, {half, 0, 0}, {0, 0, half}, black);
  scene.environment(glm::vec3(1.0f));
  Hits hits(scene);
  const glm::vec3 eye(0.0f, -1.7f, 0.0f);
  std::vector<Ray> rays;
  std::vector<double> expected;  // 0 outside the middle of the square
  constexpr int side = 48;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double u = ((x + 0.5) / side * 2 - 1) * 3 * half, v = ((y + 0.5) / side * 2 - 1) * 3 * half;
      rays.push_back({eye, 0.0f, glm::normalize(glm::vec3(glm::dvec3(u, -2, v)) - eye), 1e30f});
      double hidden = 0;
      for (const double s : {-1.0, 1.0})
        for (const double t : {-1.0, 1.0}) hidden += hidden_by_quarter((half + s * u) / height, (half + t * v) / height);
      expected.push_back(std::max(std::abs(u), std::abs(v)) < 0.75 * half ? 0.5 * (1.0 - hidden) : 0.0);
    }
  double found = 0, wanted = 0, open = 0;
  constexpr uint32_t positions = 16;
  for (uint32_t k = 0; k < positions; ++k) {
    const std::vector<glm::vec3> seen = hits.shade(rays, true, k);
    ASSERT_EQ(seen.size(), expected.size());
    for (size_t i = 0; i < seen.size(); ++i)
      if (expected[i] > 0) found += double{seen[i].x}, wanted += expected[i], open += 0.5;
  }
  EXPECT_NEAR(found, wanted, 0.1 * open);
}

// Points in two rooms with different light do not share paths through the thin wall between them.
TEST(LightAround, EndsAtAWall) {
  TestScene scene;
  const auto room = [&](double x, glm::vec3 emission) {
    for (const double s : {-1.0, 1.0}) {
      scene.quad({x + 2 * s, 0, 0}, {0, 2, 0}, {0, 0, 2}, matt(0.5f, emission));
      scene.quad({x, 0, 2 * s}, {2, 0, 0}, {0, 2, 0}, matt(0.5f, emission));
    }
    scene.quad({x, 2, 0}, {2, 0, 0}, {0, 0, 2}, matt(0.5f, emission));
  };
  room(-2.01, glm::vec3(1.0f));
  room(2.01, glm::vec3(0.0f));
  scene.quad({0, -2, 0}, {8, 0, 0}, {0, 0, 2}, matt(0.5f));
  scene.environment(glm::vec3(0.0f));
  Hits hits(scene);
  std::vector<Ray> rays;
  for (const float x : {2.01f, -2.01f}) Hits::add_rays({x, 0, 0}, {0, -1, 0}, rays);
  const std::vector<glm::vec3> both = hits.shade(rays, true);
  const auto half = both.begin() + static_cast<ptrdiff_t>(both.size() / 2);
  const glm::vec3 dark = mean({both.begin(), half}), bright = mean({half, both.end()});
  EXPECT_LT(dark.x, 1e-3f * bright.x);
  EXPECT_GT(bright.x, 0.4f);
}

// Below a bright ceiling a floor is brighter than a wall beside it, however near their points are.
TEST(LightAround, IsNotSharedBetweenAFloorAndAWall) {
  TestScene scene;
  scene.quad({0, -2, 0}, {50, 0, 0}, {0, 0, 50}, matt(0.5f));
  scene.quad({0.5, 3, 0}, {0, 5, 0}, {0, 0, 50}, matt(0.5f));
  scene.quad({0, 8, 0}, {4, 0, 0}, {0, 0, 50}, matt(0.0f, glm::vec3(1.0f)));
  scene.environment(glm::vec3(0.0f));
  Hits hits(scene);
  std::vector<Ray> floor, wall;
  Hits::add_rays({0, -1.5f, 0}, {0, -1, 0}, floor);
  Hits::add_rays({0, -1.5f, 0}, {1, 0, 0}, wall);
  std::vector<Ray> rays = floor;
  rays.insert(rays.end(), wall.begin(), wall.end());
  constexpr uint32_t positions = 16;
  glm::vec3 alone(0.0f), beside(0.0f), below(0.0f);
  for (uint32_t i = 0; i < positions; ++i) {
    const std::vector<glm::vec3> both = hits.shade(rays, true, i);
    const auto half = both.begin() + static_cast<ptrdiff_t>(both.size() / 2);
    alone += mean(hits.shade(wall, true, i));
    beside += mean({half, both.end()});
    below += mean({both.begin(), half});
  }
  EXPECT_GT(below.x, 1.3f * alone.x);
  EXPECT_NEAR(beside.x, alone.x, 0.005f * alone.x);
}

// The sky through a coloured sheet has its colour.
TEST(LightAround, SeesTheSkyThroughGlass) {
  TestScene scene;
  scene.quad({0, -2, 0}, {50, 0, 0}, {0, 0, 50}, matt(0.5f));
  sideray_material_desc red = glass();
  red.base_color[0] = 1.0f, red.base_color[1] = 0.2f, red.base_color[2] = 0.5f;
  scene.quad({0, 2, 0}, {500, 0, 0}, {0, 0, 500}, red);
  scene.environment(glm::vec3(1.0f));
  Hits hits(scene);
  const glm::vec3 found = mean(hits.shade({0, 0, 0}, {0, -1, 0}, true));
  EXPECT_GT(found.x, 0.35f);
  EXPECT_LT(found.x, 0.5f);
  EXPECT_NEAR(found.y / found.x, 0.2f, 0.01f);
  EXPECT_NEAR(found.z / found.x, 0.5f, 0.01f);
}

TEST(LightAround, IsTheSameForTheSameBatch) {
  TestScene scene;
  add_floor_and_wall(scene);
  Hits hits(scene);
  EXPECT_EQ(hits.shade({0, 0, 0}, {0, -1, 0}, true), hits.shade({0, 0, 0}, {0, -1, 0}, true));
}

// Points that weigh little in their pixel cost few paths, and are as bright.
TEST(LightAround, OfWhatWeighsLittleCostsLittle) {
  TestScene scene;
  add_floor_and_wall(scene);
  Hits hits(scene);
  glm::vec3 heavy(0.0f), light(0.0f);
  uint64_t rays_heavy = 0, rays_light = 0;
  constexpr int places = 128;
  for (int i = 0; i < places; ++i) {
    const glm::vec3 eye(0.0f, 0.0f, 0.05f * static_cast<float>(i));
    const auto position = static_cast<uint32_t>(i);
    hits.weight = 1.0f;
    heavy += mean(hits.shade(eye, {0, -1, 0}, true, position)) / static_cast<float>(places);
    rays_heavy += hits.rays_bounce;
    hits.weight = 0.04f;
    light += mean(hits.shade(eye, {0, -1, 0}, true, position)) / static_cast<float>(places);
    rays_light += hits.rays_bounce;
  }
  EXPECT_LT(rays_light, rays_heavy / 8);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(light[c], heavy[c], 0.02f * heavy[c]);
}

// Other sample positions of a pixel send other paths.
TEST(LightAround, TurnsWithThePosition) {
  TestScene scene;
  add_floor_and_wall(scene);
  Hits hits(scene);
  EXPECT_NE(hits.shade({0, 0, 0}, {0, -1, 0}, true, 0), hits.shade({0, 0, 0}, {0, -1, 0}, true, 1));
}

}  // namespace
}  // namespace sideray::rt::light_around_test
