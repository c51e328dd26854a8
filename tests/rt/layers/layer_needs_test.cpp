// Points whose radiance may be off by so much are never off by more, and what is spared grows with it.
#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <vector>

#include "rt/base/sampling.h"
#include "rt/layers/layer_needs.h"
#include "rt/shading/hit_shader.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

// Surfaces of many kinds at z = 0, seen from above, between posts that throw shadows, under a dozen lights.
class LitQuads {
 public:
  LitQuads() {
    TestScene scene;
    std::vector<sideray_material_desc> kinds{blended({0.9f, 0.5f, 0.2f}, 0.5f), glass(), mirror(), glass(), glass()};
    kinds[0].roughness = 0.4f;
    kinds[3].clearcoat = 1.0f, kinds[3].clearcoat_roughness = 0.0f, kinds[3].clearcoat_normal_scale = 1.0f;
    kinds[4].roughness = 0.3f;
    kinds_ = static_cast<uint32_t>(kinds.size());
    for (uint32_t k = 0; k < kinds_; ++k)
      scene.quad({3.0f * static_cast<float>(k), 0, 0}, {1, 0, 0}, {0, 1, 0}, kinds[k]);
    for (int i = 0; i < 8; ++i)
      scene.quad({2.0f * static_cast<float>(i) - 1.0f, 1.5f, 1.0f}, {0.3f, 0, 0}, {0, 0, 0.8f}, plain_material());
    scene.quad({0, 0, 6}, {0, 30, 0}, {30, 0, 0}, plain_material());
    scene.environment(glm::vec3(0.3f, 0.4f, 0.5f));
    std::vector<sideray_light> lights;
    for (int i = 0; i < 12; ++i)
      lights.push_back(
          point_light({std::fmod(5.3f * static_cast<float>(i), 14.0f), i % 2 ? 3.0f : -2.0f, 2.0f + 0.3f * float(i)},
                      10.0f / static_cast<float>(1 << i)));
    scene.lights(lights);
    shading_ = std::make_unique<ShadingScene>(scene.commit());
    intersector_.set_scene(shading_->snapshot);
  }

  std::vector<SurfacePoint> points(uint32_t count) const {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    std::vector<SurfacePoint> points;
    for (uint32_t i = 0; i < count; ++i) {
      Hit hit{};
      hit.instance = i % kinds_, hit.primitive = i / kinds_ % 2;
      hit.u = 0.5f * unit(random), hit.v = 0.5f * unit(random);
      hit.front = true, hit.distance = 1.0;
      const glm::vec3 to_eye = glm::normalize(glm::vec3(unit(random) - 0.5f, unit(random) - 0.5f, 0.1f + unit(random)));
      points.push_back(surface_point(*shading_, hit, {to_eye, 0.0f, -to_eye, 1e30f}, {}));
      points.back().key = random_key({3, i});
    }
    return points;
  }

  struct Shaded {
    std::vector<glm::vec3> radiance;
    std::vector<RoughReflection> rough;
    uint64_t rays, spared, skipped;
  };
  Shaded shade(const std::vector<SurfacePoint>& points, bool shadows = true, bool tell_rough = false) const {
    HitShader shader;
    shader.begin(*shading_, intersector_, shadows, tell_rough);
    shader.expect_mirrored(brightest_mirrored(*shading_->snapshot));
    Shaded shaded{std::vector<glm::vec3>(points.size()), {}, 0, 0, 0};
    shader.shade(points, shaded.radiance.data());
    shaded.rough.assign(shader.rough().begin(), shader.rough().end());
    shaded.rays = shader.rays_reflection + shader.rays_shadow;
    shaded.spared = shader.rays_skipped, shaded.skipped = shader.points_skipped;
    return shaded;
  }

 private:
  uint32_t kinds_;
  std::unique_ptr<ShadingScene> shading_;
  Intersector intersector_{""};
};

// Rounding of sums in another order.
void expect_within(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& truth,
                   const std::vector<SurfacePoint>& points) {
  for (size_t i = 0; i < test.size(); ++i)
    for (int c = 0; c < 3; ++c)
      ASSERT_LE(std::abs(test[i][c] - truth[i][c]), points[i].allowance * 1.00001f + 1e-5f * (1.0f + truth[i][c]))
          << i << " channel " << c << " allowance " << points[i].allowance;
}

TEST(LayerNeeds, RadianceIsOffByNoMoreThanItMayBe) {
  const LitQuads scene;
  std::vector<SurfacePoint> points = scene.points(2000);
  for (const bool shadows : {true, false})
    for (const bool tell_rough : {true, false}) {
      for (SurfacePoint& p : points) p.allowance = 0.0f;
      const LitQuads::Shaded truth = scene.shade(points, shadows, tell_rough);
      EXPECT_EQ(truth.spared, 0u);
      EXPECT_EQ(truth.skipped, 0u);
      uint64_t before = truth.rays;
      for (const float allowance : {1e-6f, 1e-4f, 1e-3f, 1e-2f, 0.1f, 1.0f, 10.0f}) {
        for (SurfacePoint& p : points) p.allowance = allowance;
        const LitQuads::Shaded test = scene.shade(points, shadows, tell_rough);
        expect_within(test.radiance, truth.radiance, points);
        EXPECT_LE(test.rays, before) << allowance;
        EXPECT_LE(test.rays + test.spared, truth.rays) << allowance;
        before = test.rays;
      }
      EXPECT_LT(before, truth.rays);
    }
}

TEST(LayerNeeds, EachPointHasItsOwnAllowance) {
  const LitQuads scene;
  std::vector<SurfacePoint> points = scene.points(2000);
  const LitQuads::Shaded truth = scene.shade(points);
  for (size_t i = 0; i < points.size(); ++i)
    points[i].allowance = i % 7 == 0 ? 0.0f : std::pow(10.0f, static_cast<float>(i % 13) - 9.0f);
  const LitQuads::Shaded test = scene.shade(points);
  expect_within(test.radiance, truth.radiance, points);
  EXPECT_GT(test.spared, 0u);
}

// What is filtered goes to other pixels: it is what it was, to the bit.
TEST(LayerNeeds, FilteredReflectionsAreTracedInFull) {
  const LitQuads scene;
  std::vector<SurfacePoint> points = scene.points(500);
  const LitQuads::Shaded truth = scene.shade(points, true, true);
  for (SurfacePoint& p : points) p.allowance = 1.0f;
  const LitQuads::Shaded test = scene.shade(points, true, true);
  ASSERT_EQ(test.rough.size(), truth.rough.size());
  size_t rough = 0;
  for (size_t i = 0; i < test.rough.size(); ++i) {
    EXPECT_EQ(test.rough[i].weight, truth.rough[i].weight);
    if (truth.rough[i].weight == glm::vec3(0.0f)) continue;
    EXPECT_EQ(test.rough[i].radiance, truth.rough[i].radiance);
    EXPECT_EQ(test.rough[i].nearness, truth.rough[i].nearness);
    ++rough;
  }
  EXPECT_GT(rough, 100u);
  EXPECT_GT(test.spared, 0u);
}

TEST(LayerNeeds, EverythingAllowedLeavesNoRay) {
  const LitQuads scene;
  std::vector<SurfacePoint> points = scene.points(500);
  for (SurfacePoint& p : points) p.allowance = 1e6f;
  const LitQuads::Shaded test = scene.shade(points);
  EXPECT_EQ(test.rays, 0u);
  EXPECT_EQ(test.skipped, 500u);
}

}  // namespace
}  // namespace sideray::rt
