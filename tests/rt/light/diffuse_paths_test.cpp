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
  const std::vector<Cone> cones(count, Cone{0.0f, 1e-3f});
  std::vector<uint32_t> keys(count);
  for (uint32_t i = 0; i < count; ++i) keys[i] = 0x9e3779b9u * (i + 1);
  std::vector<glm::vec3> radiance(count);
  std::vector<float> nearness(count);
  DiffusePaths paths;
  paths.begin(shading, intersector, true, nullptr);
  paths.follow(rays, cones, keys, radiance.data(), nearness.data());
  float sum = 0.0f;
  for (const glm::vec3 light : radiance) sum += light.x;
  return sum / static_cast<float>(count);
}

// The lit half of the sky lights the floor as half of a uniform one does: with 2 * .5 * .5. The lobe that the sky is averaged
// over reaches past the edge of the wall. By all of the sky or nothing it would be .25, whichever half is hidden.
TEST(DiffusePaths, SeeThePartOfTheSkyThatIsOpen) {
  EXPECT_NEAR(light_of_floor(0), 0.5f, 0.02f);
  EXPECT_NEAR(light_of_floor(-1), 0.5f, 0.1f) << "the dark half is hidden";
  EXPECT_NEAR(light_of_floor(1), 0.0f, 0.1f) << "the lit half is hidden";
}

}  // namespace
}  // namespace sideray::rt::diffuse_paths_test
