// Compares light by paths from a floor, under a sky that a wall partly hides, with closed forms.
#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include <numeric>
#include <vector>

#include "rt/light/diffuse_paths.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::diffuse_paths_test {
namespace {

using namespace test;

// Returns the mean light of paths that hit a floor of albedo .5. The sky is 2 toward +X and 0 toward -X; an infinite
// black wall hides the side of sign `hidden`, or none.
float light_of_floor(double hidden) {
  TestScene scene;
  scene.quad({0, -1, 0}, {1, 0, 0}, {0, 0, 1}, matt(0.5f));
  if (hidden != 0.0) scene.quad({1e-3 * hidden, 0, 0}, {0, 5000, 0}, {0, 0, 5000}, matt(0.0f));
  std::vector<glm::vec3> sky(64 * 32, glm::vec3(0.0f));
  // u = .5 is toward -Z, and u grows toward +X.
  for (size_t i = 0; i < sky.size(); ++i)
    if (i % 64 >= 32) sky[i] = glm::vec3(2.0f);
  scene.scene.set_environment(64, 32, &sky[0].x, 1.0f, 0.0f);
  const ShadingScene shading(scene.commit());
  Intersector intersector("");
  intersector.set_scene(shading.snapshot);
  constexpr uint32_t count = 4096;
  // On the side that is seen: close by the wall the half behind it is all that is hidden.
  const float x = hidden != 0.0 ? static_cast<float>(-1e-3 * hidden) : 0.0f;
  const std::vector<Ray> rays(count, Ray{{x, -0.5f, 0.0f}, 0.0f, {0.0f, -1.0f, 0.0f}, 1e30f});
  const std::vector<glm::vec3> normals(count, glm::vec3(0.0f, -1.0f, 0.0f));
  const std::vector<float> widths(count, 0.0f);
  std::vector<uint32_t> keys(count);
  for (uint32_t i = 0; i < count; ++i) keys[i] = 0x9e3779b9u * (i + 1);
  std::vector<PathLight> found(count);
  DiffusePaths paths;
  paths.begin(shading, intersector, true, nullptr);
  paths.follow({rays, normals, widths, keys}, found.data());
  float sum = 0.0f;
  for (const PathLight& light : found) sum += light.radiance.x;
  return sum / static_cast<float>(count);
}

// The lit half of the sky lights the floor as half of a uniform one does: with 2 * .5 * .5. The lobe that the sky is averaged
// over reaches past the edge of the wall. By all of the sky or nothing it would be .25, whichever half is hidden.
TEST(DiffusePaths, SeeThePartOfTheSkyThatIsOpen) {
  EXPECT_NEAR(light_of_floor(0), 0.5f, 0.02f);
  EXPECT_NEAR(light_of_floor(-1), 0.5f, 0.1f) << "the dark half is hidden";
  EXPECT_NEAR(light_of_floor(1), 0.0f, 0.1f) << "the lit half is hidden";
}

// Returns the mean light that paths from the origin of a black floor find below a square panel of half a unit's side.
// `screen`: height of a black sheet between, or 0.
double light_below(const sideray_material_desc& panel, double height, PathLight& mean, double screen = 0.0) {
  TestScene scene;
  if (screen > 0.0) scene.quad({0, screen, 0}, {5, 0, 0}, {0, 0, 5}, matt(0.0f));
  scene.quad({0, 0, 0}, {0, 0, 5}, {5, 0, 0}, matt(0.0f));
  scene.quad({0, height, 0}, {0.25, 0, 0}, {0, 0, 0.25}, panel);
  scene.environment(glm::vec3(0.0f));
  ShadingScene shading(scene.commit());
  shading.emitters = std::make_shared<const EmittersWhenUsed>(shading.snapshot);
  Intersector intersector("");
  intersector.set_scene(shading.snapshot);
  constexpr uint32_t count = 16384;
  std::vector<Ray> rays;
  std::vector<uint32_t> keys;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t key = random_key({i, 7}), other = hash_bits(key);
    const glm::vec3 d = sample_cosine({unit_float(key), unit_float(other)});
    rays.push_back({{0.0f, 1e-4f, 0.0f}, 0.0f, {d.x, d.z, d.y}, farthest});
    keys.push_back(hash_bits(other));
  }
  const std::vector<glm::vec3> normals(count, glm::vec3(0, 1, 0));
  const std::vector<float> widths(count, 0.0f);
  std::vector<PathLight> found(count);
  DiffusePaths paths;
  paths.begin(shading, intersector, true, nullptr);
  paths.follow({rays, normals, widths, keys}, found.data());
  mean = {};
  double squares = 0.0;
  for (const PathLight& l : found) {
    mean.radiance += l.radiance / static_cast<float>(count);
    mean.emitter_nearness += l.emitter_nearness / static_cast<float>(count);
    squares += std::pow(static_cast<double>(l.radiance.x), 2.0) / count;
  }
  const auto value = static_cast<double>(mean.radiance.x);
  return std::sqrt((squares - value * value) / count);
}

// Returns the share of the cosine-weighted directions in which the origin sees the panel.
double form_factor(double height) {
  constexpr int steps = 100;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j) {
      const double x = 0.5 * ((i + 0.5) / steps - 0.5), z = 0.5 * ((j + 0.5) / steps - 0.5);
      const double d2 = x * x + z * z + height * height;
      sum += height * height / (M_PI * d2 * d2) * 0.25 / (steps * steps);
    }
  return sum;
}

// A panel above a floor adds its radiance times its form factor, and its coverage if it is translucent, whether random
// rays often meet it or hardly ever.
TEST(DiffusePaths, SampleEmitters) {
  sideray_material_desc veil = blended({0, 0, 0}, 0.25f);
  veil.specular = 0.0f;
  for (float& e : veil.emissive) e = 8.0f;
  for (const double height : {0.1, 0.5, 3.0})
    for (const bool translucent : {false, true}) {
      PathLight mean;
      const double error = light_below(translucent ? veil : glowing(glm::vec3(8.0f)), height, mean);
      const double expected = 8.0 * (translucent ? 0.25 : 1.0) * form_factor(height);
      EXPECT_NEAR(static_cast<double>(mean.radiance.x), expected, 4.0 * error + 0.01 * expected) << height << translucent;
      EXPECT_LT(error, (height > 1.0 ? 0.01 : 0.05) * expected) << height << translucent;
      if (height < 1.0) continue;
      EXPECT_NEAR(static_cast<double>(mean.emitter_nearness), 1.0 / height, 0.02) << translucent;
    }
}

// Whatever is before a panel hides it, just before it, too.
TEST(DiffusePaths, SampleNoEmittersBehindOtherSurfaces) {
  for (const double screen : {0.1, 0.5, 0.8, 0.99}) {
    PathLight mean;
    light_below(glowing(glm::vec3(8.0f)), 1.0, mean, screen);
    EXPECT_EQ(mean.radiance, glm::vec3(0.0f)) << screen;
  }
}

}  // namespace
}  // namespace sideray::rt::diffuse_paths_test
