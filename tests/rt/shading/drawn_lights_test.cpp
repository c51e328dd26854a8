// Tests randomly drawn lights: their mean is that of all lights, less important points take fewer rays, and bright
// lights are always traced.
#include <gmock/gmock.h>

#include <cmath>
#include <vector>

#include "rt/base/sampling.h"
#include "rt/shading/hit_shader.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

// A floor under six lamps of many strengths, half of them behind a board, and a mirror that shows it.
struct Lamps {
  explicit Lamps(float strength) {
    TestScene scene;
    scene.quad({0, 0, 0}, {3, 0, 0}, {0, 3, 0}, plain_material());
    scene.quad({0, 2, 1}, {1, 0, 0}, {0, 0, 1}, mirror());
    scene.quad({-1, 0, 1}, {0.8f, 0, 0}, {0, 3, 0}, plain_material());
    std::vector<sideray_light> lights;
    for (int i = 0; i < 6; ++i) {
      const auto n = static_cast<float>(i);
      lights.push_back(point_light({i % 2 == 0 ? -1.0f : 1.0f, 0.5f * n - 1.0f, 2.0f}, strength / (1.0f + n * n)));
      lights.back().intensity[i % 3] *= 2.0f;
    }
    scene.lights(lights);
    shading = std::make_unique<ShadingScene>(scene.commit());
    intersector.set_scene(shading->snapshot);
  }

  // Returns the point that a ray hits: the floor, or the mirror in which the floor is seen.
  SurfacePoint point(bool in_mirror) const {
    const glm::vec3 eye(0.0f, -2.0f, 1.0f), to = in_mirror ? glm::vec3(0.1f, 2.0f, 0.4f) : glm::vec3(0.1f, -0.2f, 0.0f);
    const std::vector<Ray> rays{{eye, 0.0f, glm::normalize(to - eye), farthest}};
    Hit hit{};
    if (in_mirror) {
      uint32_t count = 0;
      intersector.nearest_layers(LayerSet::all_translucent, rays, {.coherent = true}, &hit, &count);
      EXPECT_EQ(count, 1u);
    } else {
      intersector.nearest_opaque(rays, {.coherent = true}, &hit);
      EXPECT_NE(hit.instance, no_instance);
    }
    return surface_point(*shading, hit, rays[0], {0.0f, 0.001f});
  }

  struct Shaded {
    std::vector<glm::vec3> radiance;
    uint64_t rays;
  };
  Shaded shade(SurfacePoint point, float weight, float error, uint32_t keys) const {
    point.weight = weight;
    std::vector<SurfacePoint> points(keys, point);
    // Lights are drawn by the place: these are different, and lit alike.
    for (uint32_t i = 0; i < keys; ++i) points[i].position.x += 1e-6f * (static_cast<float>(i) - 0.5f * static_cast<float>(keys));
    HitShader shader;
    shader.begin(*shading, intersector, {.error = error});
    Shaded shaded{std::vector<glm::vec3>(keys), 0};
    shader.shade(points, shaded.radiance.data());
    shaded.rays = shader.rays_shadow;
    return shaded;
  }

  std::unique_ptr<ShadingScene> shading;
  Intersector intersector{""};
};

TEST(DrawnLights, mean_what_all_lights_bring) {
  constexpr uint32_t keys = 8000;
  const Lamps lamps(1.0f);
  for (const bool in_mirror : {false, true})
    for (const float weight : {1.0f, 0.05f, 0.002f}) {
      const SurfacePoint point = lamps.point(in_mirror);
      const Lamps::Shaded all = lamps.shade(point, weight, 0.0f, 1);
      const Lamps::Shaded drawn = lamps.shade(point, weight, 1.0f / 64, keys);
      EXPECT_GE(all.rays, 4u);
      EXPECT_LT(static_cast<double>(drawn.rays), (weight == 1.0f ? 0.9 : 0.5) * keys * static_cast<double>(all.rays))
          << in_mirror << ' ' << weight;
      for (int c = 0; c < 3; ++c) {
        double sum = 0, squares = 0;
        for (const glm::vec3& v : drawn.radiance) {
          const auto x = static_cast<double>(v[c]);
          sum += x, squares += x * x;
        }
        const double mean = sum / keys, deviation = std::sqrt(squares / keys - mean * mean);
        EXPECT_GT(deviation, 0.0);
        EXPECT_NEAR(mean, static_cast<double>(all.radiance[0][c]), 4 * deviation / std::sqrt(keys))
            << in_mirror << ' ' << weight;
        // What is left to chance is at most what a ray brings in the pixel: less than donors may differ by.
        EXPECT_LT(deviation * static_cast<double>(weight), 1.0 / 64);
      }
    }
}

TEST(DrawnLights, need_rays_in_proportion) {
  constexpr uint32_t keys = 2000;
  const Lamps lamps(1.0f);
  const SurfacePoint point = lamps.point(false);
  uint64_t before = 0;
  for (const float weight : {0.0001f, 0.001f, 0.01f, 0.1f, 1.0f}) {
    const uint64_t rays = lamps.shade(point, weight, 1.0f / 64, keys).rays;
    EXPECT_GT(rays, before) << weight;
    before = rays;
  }
  EXPECT_LT(lamps.shade(point, 0.0001f, 1.0f / 64, keys).rays, keys / 4);
}

// No chance where each light is bright enough for a ray of its own.
TEST(DrawnLights, are_all_lights_where_each_counts) {
  const Lamps bright(1000.0f);
  const SurfacePoint point = bright.point(false);
  const Lamps::Shaded all = bright.shade(point, 1.0f, 0.0f, 64), drawn = bright.shade(point, 1.0f, 1.0f / 64, 64);
  EXPECT_EQ(drawn.rays, all.rays);
  for (size_t i = 0; i < all.radiance.size(); ++i)
    EXPECT_LT(glm::distance(drawn.radiance[i], all.radiance[i]), 1e-5f * glm::length(all.radiance[i]));
}

}  // namespace
}  // namespace sideray::rt
