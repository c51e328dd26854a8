// Tests what counts as translucent in front of the sky.
#include "rt/light/veils.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rt/tracer_scene.h"

namespace sideray::rt::veils_test {
namespace {

using namespace test;

// Wind moves surfaces between commits, and sprites are drawn with each frame.
TEST(Veils, AreTranslucentAndStandStillAndOccludeTheSky) {
  TestScene scene;
  scene.quad({0, 1, 0}, {1, 0, 0}, {0, 0, 1}, blended({1, 1, 1}, 0.5f));
  model::Snapshot snapshot = *scene.commit();
  model::Instance& pane = snapshot.instances[0];
  EXPECT_TRUE(veils_sky(snapshot));
  pane.wind = 1;
  EXPECT_FALSE(veils_sky(snapshot));
  pane.wind = 0, pane.sprites = 1;
  EXPECT_FALSE(veils_sky(snapshot));
  pane.sprites = 0, pane.visibility = SIDERAY_VISIBLE_ALL & ~SIDERAY_VISIBLE_AO;
  EXPECT_FALSE(veils_sky(snapshot));
  pane.visibility = SIDERAY_VISIBLE_ALL;
  snapshot.materials[pane.material].translucent = false;
  EXPECT_FALSE(veils_sky(snapshot));
}

TEST(Veils, MultiplyAlongARayAndKeepTheNearestDistance) {
  TestScene scene;
  for (const float y : {3.0f, 1.0f, 2.0f}) scene.quad({0, y, 0}, {1, 0, 0}, {0, 0, 1}, blended({1, 1, 1}, 0.5f));
  scene.quad({0, 0.5f, 0}, {1, 0, 0}, {0, 0, 1}, blended({1, 1, 1}, 0.5f), SIDERAY_VISIBLE_ALL & ~SIDERAY_VISIBLE_AO);
  const ShadingScene shading(scene.commit());
  Intersector intersector("");
  intersector.set_scene(shading.snapshot);
  const std::vector<Ray> rays{{{0.1f, 0, 0.2f}, 0.0f, {0, 1, 0}, farthest}, {{5, 0, 0}, 0.0f, {0, 1, 0}, farthest}};
  Veils veils;
  veils.meet(shading, intersector, rays, false);
  EXPECT_NEAR(veils.through(0), 0.125f, 1e-4f);
  EXPECT_NEAR(veils.distance(0), 1.0f, 1e-5f);
  EXPECT_EQ(veils.through(1), 1.0f);
  EXPECT_EQ(veils.distance(1), INFINITY);
}

}  // namespace
}  // namespace sideray::rt::veils_test
