// Tests the cells that rays pass: no box that a ray has passed is missed, and most others are recognized as not passed.
#include "rt/reach/tile_reach.h"

#include <gtest/gtest.h>

#include <random>

#include "rt/reach/wanted_tiles.h"

namespace sideray::rt::tests {
namespace {

using model::Bounds;

bool passes(const Ray& ray, const Bounds& box) {
  double from = ray.t_near, to = ray.t_far;
  for (int i = 0; i < 3; ++i) {
    const double a = (double{box.minimum[i]} - double{ray.origin[i]}) / double{ray.direction[i]};
    const double b = (double{box.maximum[i]} - double{ray.origin[i]}) / double{ray.direction[i]};
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to;
}

class Random {
 public:
  float in(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine_); }
  // Of any size.
  float sized(float least, float most) { return std::exp(in(std::log(least), std::log(most))); }
  glm::vec3 vector(float size) { return {in(-size, size), in(-size, size), in(-size, size)}; }

 private:
  std::mt19937 engine_{1};
};

TEST(RayCells, MissNoBoxThatARayHasPassed) {
  Random random;
  const ReachCube cube{{3.0f, -1.0f, 2.0f}, 2.5f};
  int passed = 0;
  for (int i = 0; i < 200000; ++i) {
    const float far = i % 5 == 0 ? INFINITY : random.sized(1e-3f, 100.0f);
    const Ray ray{cube.middle + random.vector(random.sized(0.1f, 60.0f)), 0.0f, random.vector(random.sized(0.01f, 3.0f)), far};
    RayCells cells;
    cells.add(cube, ray, ray.t_near, ray.t_far);
    // About a point of the ray, or anywhere.
    const float along = random.in(0.0f, std::min(far, 30.0f));
    const glm::vec3 middle = i % 2 == 0 ? ray.origin + ray.direction * along : cube.middle + random.vector(5.0f);
    const glm::vec3 half = glm::abs(random.vector(random.sized(1e-4f, 3.0f)));
    const Bounds box{middle - half, middle + half};
    if (!passes(ray, box)) continue;
    ++passed;
    ASSERT_TRUE(cells.meets(cube, box)) << i;
  }
  EXPECT_GT(passed, 80000);
}

TEST(RayCells, TellMostBoxesThatNoRayHasPassed) {
  Random random;
  const ReachCube cube;
  RayCells cells;
  // Up from a floor to a lamp.
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 origin(random.in(-0.3f, 0.3f), -1.0f, random.in(-0.3f, 0.3f));
    cells.add(cube, {origin, 0.0f, glm::vec3(0.0f, 0.9f, 0.0f) - origin, 1.0f}, 0.0f, 1.0f);
  }
  const auto meets = [&](glm::vec3 middle) { return cells.meets(cube, {middle - 0.05f, middle + 0.05f}); };
  EXPECT_TRUE(meets({0.0f, 0.0f, 0.0f}));
  EXPECT_TRUE(meets({0.1f, 0.0f, 0.0f}));
  EXPECT_FALSE(meets({0.4f, 0.0f, 0.0f}));
  EXPECT_FALSE(meets({0.0f, 0.0f, -0.4f}));
  EXPECT_FALSE(meets({0.3f, 0.8f, 0.0f}));
  EXPECT_FALSE(meets({0.0f, 3.0f, 0.0f}));
  EXPECT_FALSE(meets({0.0f, 300.0f, 0.0f}));
  EXPECT_FALSE(cells.meets(cube, Bounds{}));
}

TEST(TileReach, KnowsWhatItsTilesFollowed) {
  TileReach reach(3);
  const Ray up{{0.0f, -0.5f, 0.0f}, 0.0f, {0.0f, 1.0f, 0.0f}, 1.0f};
  const Bounds above{{-0.1f, 0.2f, -0.1f}, {0.1f, 0.4f, 0.1f}}, beside{{0.5f, 0.2f, 0.5f}, {0.6f, 0.4f, 0.6f}};
  EXPECT_EQ(Following::now(), nullptr);
  {
    Following rays(&reach, Following::Rays::of_masks);
    ASSERT_EQ(Following::now(), &rays);
    rays.follow({&up, 1}, false);
    rays.add_to(1);
  }
  {
    Following rays(&reach, Following::Rays::of_layers);
    rays.follow({&up, 1}, false);
    rays.add_to(0);
    rays.follow({&up, 1}, true);
    rays.add_to(2);
  }
  const Following nothing(nullptr, Following::Rays::of_masks);
  EXPECT_EQ(Following::now(), nullptr);
  for (size_t tile = 0; tile < 3; ++tile) {
    EXPECT_EQ(reach.meets_occluders(tile, above), tile == 1) << tile;
    EXPECT_EQ(reach.meets_sprites(tile, above), tile == 2) << tile;
    EXPECT_FALSE(reach.meets_mirrored(tile, above));
    EXPECT_FALSE(reach.meets_occluders(tile, beside) || reach.meets_sprites(tile, beside));
  }
}

TEST(WantedTiles, GrowWithinThePicture) {
  const std::vector<uint8_t> corner{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};  // 4 x 3
  EXPECT_EQ(grown(corner, 4, 0), corner);
  EXPECT_EQ(grown(corner, 4, 1), (std::vector<uint8_t>{1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(grown(corner, 4, 9), std::vector<uint8_t>(12, 1));
}

}  // namespace
}  // namespace sideray::rt::tests
