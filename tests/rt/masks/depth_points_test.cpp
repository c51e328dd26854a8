// Tests the origins of rays of opaque pixels: the point of the depth, or a ray's hit of the same surface.
#include "rt/masks/depth_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

// A wall at z = -100 that leans by a quarter, in D24 with the near plane at 0.01: a step is 0.06.
class CoarseWall : public testing::Test {
 protected:
  static constexpr uint32_t size = DepthPoints::tile_size;
  static constexpr double slope = 0.25;
  const glm::vec3 normal_ = glm::normalize(glm::vec3(static_cast<float>(slope), 0.0f, 1.0f));

  void SetUp() override {
    request_.view.clip_from_local = glm::perspectiveRH_NO(0.5, 1.0, 0.01, 1e6);
    request_.view.local_from_clip = glm::inverse(request_.view.clip_from_local);
    request_.width = request_.height = size;
    request_.depth = {texels_.data(), size * 4, DepthFormat::d24s8};
    const ViewRays view(request_.view, size, size);
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const Ray ray = view.ray(x, y);
        const glm::dvec3 d(ray.direction);
        const double t = -100.0 / (d.z + slope * d.x);
        const glm::dvec4 clip = request_.view.clip_from_local * glm::dvec4(t * d, 1.0);
        const auto stored = static_cast<uint32_t>(std::lround((0.5 + 0.5 * clip.z / clip.w) * 16777215.0)) << 8;
        std::memcpy(&texels_[4 * (size_t{y} * size + x)], &stored, 4);
        points_.push_back({t, normal_});
      }
  }

  std::vector<DepthPoint> gather() {
    const ViewRays view(request_.view, size, size);
    DepthPoints points;
    const PointTile& tile = points.gather(request_, view, 0, 0);
    std::vector<DepthPoint> result;
    for_each_pixel(tile.drawn, [&](uint32_t pixel) { result.push_back(point_at(tile, pixel)); });
    return result;
  }
  // From the wall, on the eye's side.
  static double height(glm::vec3 p) {
    return (double{p.z} + slope * double{p.x} + 100.0) / std::sqrt(1.0 + slope * slope);
  }

  MaskRequest request_;
  std::vector<OpaquePoint> points_;
  std::vector<std::byte> texels_ = std::vector<std::byte>(size_t{4} * size * size);
};

TEST_F(CoarseWall, TheDepthKeepsRaysOffBySteps) {
  double highest = 0;
  for (const DepthPoint& p : gather()) highest = std::max(highest, height(p.front));
  EXPECT_GT(highest, 0.02);
}

TEST_F(CoarseWall, PointsOfRaysAreExact) {
  request_.points = points_;
  const std::vector<DepthPoint> points = gather();
  ASSERT_EQ(points.size(), size_t{size} * size);
  for (const DepthPoint& p : points) {
    EXPECT_GT(height(p.front), 0.0);
    EXPECT_LT(height(p.front), 2e-4);
    EXPECT_LT(height(p.back), 0.0);
    EXPECT_NEAR(glm::dot(p.normal, normal_), 1.0f, 1e-6f);
    EXPECT_EQ(p.doubt, 0.0f);
    EXPECT_EQ(p.skip, 0.0f);
  }
}

// If the ray hits another surface than the drawn one, the depth is used.
TEST_F(CoarseWall, PointsOfAnotherSurfaceDoNotCount) {
  const std::vector<DepthPoint> expected = gather();
  for (OpaquePoint& p : points_) p.distance -= 1.0;
  request_.points = points_;
  const std::vector<DepthPoint> points = gather();
  ASSERT_EQ(points.size(), expected.size());
  for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].front, expected[i].front);
}

// Backs of surfaces seen from behind: their normal is turned to the eye.
TEST_F(CoarseWall, NormalsFaceTheEye) {
  const std::vector<DepthPoint> expected = [&] {
    request_.points = points_;
    return gather();
  }();
  for (OpaquePoint& p : points_) p.normal = -p.normal;
  const std::vector<DepthPoint> points = gather();
  for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].normal, expected[i].normal);
}

}  // namespace
}  // namespace sideray::rt
