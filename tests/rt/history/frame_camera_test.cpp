// Tests what reprojection asks of a frame's camera: places and points, with both projections.
#include "rt/history/frame_camera.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "rt/tracer_scene.h"

namespace sideray::rt::frame_camera_test {
namespace {

using namespace test;

constexpr uint32_t width = 96, height = 64;
const glm::dvec3 eye{1.0, 2.0, 3.0}, target{1.5, 1.0, -2.0};

TraceView view_of(bool perspective_view, glm::dvec3 at = eye, glm::dvec3 toward = target) {
  return perspective_view ? perspective(at, toward, 0.9, double{width} / height)
                          : orthographic(at, toward, 2.0, double{width} / height);
}

class CameraOfAFrame : public testing::TestWithParam<bool> {
 protected:
  FrameCamera camera_{view_of(GetParam()), width, height};
};

TEST_P(CameraOfAFrame, shows_a_pixels_points_at_the_pixel) {
  for (const glm::dvec2 pixel : {glm::dvec2(0, 0), glm::dvec2(95, 63), glm::dvec2(40.25, 7.5)})
    for (const double depth : {3.0, 50.0}) {
      const std::optional<glm::dvec2> place = camera_.place(camera_.origin_at(pixel) + depth * camera_.ray_at(pixel));
      ASSERT_TRUE(place);
      EXPECT_NEAR(place->x, pixel.x, 1e-6);
      EXPECT_NEAR(place->y, pixel.y, 1e-6);
    }
}

TEST_P(CameraOfAFrame, meets_no_plane_from_its_edge_or_behind) {
  const glm::dvec2 pixel(30, 20);
  const glm::dvec3 way = camera_.direction(pixel), ahead = camera_.origin_at(pixel) + 10.0 * way;
  const glm::dvec3 across = glm::normalize(glm::cross(way, glm::dvec3(0, 1, 0)));
  const std::optional<double> met = camera_.distance(pixel, ahead, -way);
  ASSERT_TRUE(met);
  EXPECT_NEAR(*met, GetParam() ? 10.0 : 6.0, 1e-9) << "rays of orthographic views begin a picture's height before it";
  EXPECT_TRUE(camera_.distance(pixel, ahead, glm::normalize(across + 0.05 * way)));
  EXPECT_FALSE(camera_.distance(pixel, ahead + across, glm::normalize(across + 0.01 * way)));
  EXPECT_FALSE(camera_.distance(pixel, camera_.origin_at(pixel) - 10.0 * way, way));
}

// The point of a pixel's plane that another place of the picture shows is on the plane, and is shown there.
TEST_P(CameraOfAFrame, finds_the_point_of_a_plane_beside_a_pixel) {
  const glm::dvec2 pixel(30, 20), beside(33.5, 17.25);
  const SeenPlane plane{10.0, glm::normalize(glm::dvec3(0.2, 1.0, 0.3))};
  const std::optional<glm::dvec3> at = camera_.point(pixel, plane, pixel), there = camera_.point(pixel, plane, beside);
  ASSERT_TRUE(at && there);
  EXPECT_LT(glm::distance(*camera_.place(*at), pixel), 1e-6);
  EXPECT_LT(glm::distance(*camera_.place(*there), beside), 1e-6);
  EXPECT_NEAR(glm::dot(*there - *at, plane.normal), 0.0, 1e-9);
  EXPECT_NEAR(*camera_.distance(pixel, *at, plane.normal), 10.0, 1e-9);
}

TEST_P(CameraOfAFrame, keeps_its_places_where_the_space_moves) {
  FrameCamera moved = camera_;
  const glm::dvec3 by(2048.0, -1024.0, 512.0), point = target + glm::dvec3(0.3, 0.2, 0.1);
  moved.shift(by);
  EXPECT_LT(glm::distance(*moved.place(point + by), *camera_.place(point)), 1e-6);
  EXPECT_LT(glm::distance(moved.origin_at({5, 6}), camera_.origin_at({5, 6}) + by), 1e-9);
}

TEST_P(CameraOfAFrame, sees_as_another_that_neither_moves_nor_turns) {
  const auto sees_as = [&](glm::dvec3 at, glm::dvec3 toward) {
    return camera_.sees_as(FrameCamera(view_of(GetParam(), at, toward), width, height));
  };
  EXPECT_TRUE(sees_as(eye, target));
  const glm::dvec3 aside(0.01, 0, 0);
  EXPECT_FALSE(sees_as(eye + aside, target + aside)) << "moved";
  EXPECT_FALSE(sees_as(eye, target + aside)) << "turned";
  EXPECT_FALSE(camera_.sees_as(FrameCamera(view_of(!GetParam()), width, height)));
  EXPECT_FALSE(camera_.sees_as(FrameCamera(view_of(GetParam()), width, height + 1)));
}

TEST_P(CameraOfAFrame, shares_lines_with_another_that_shifts_its_picture) {
  const auto shares_lines = [&](const TraceView& view) { return camera_.shares_lines(FrameCamera(view, width, height)); };
  const TraceView view = view_of(GetParam());
  TraceView jittered = view;
  jittered.clip_from_local = glm::translate(glm::dmat4(1.0), glm::dvec3(0.01, 0, 0)) * view.clip_from_local;
  const glm::dvec3 aside(0.01, 0, 0);
  EXPECT_TRUE(shares_lines(view));
  EXPECT_TRUE(shares_lines(jittered));
  EXPECT_EQ(shares_lines(view_of(GetParam(), eye, target + aside)), GetParam()) << "turned";
  EXPECT_EQ(shares_lines(view_of(GetParam(), eye + aside, target + aside)), !GetParam()) << "moved";
  EXPECT_FALSE(shares_lines(view_of(!GetParam())));
}

// A pixel of 64 in a height of 4 is 1 / 16 wide; in perspective it is as wide as the picture's angle says.
TEST_P(CameraOfAFrame, knows_how_wide_a_pixel_is) {
  const double at_ten = GetParam() ? 10.0 * 2.0 * std::tan(0.45) / height : 4.0 / height;
  EXPECT_NEAR(camera_.breadth(10.0), at_ten, 1e-3 * at_ten);
}

TEST_P(CameraOfAFrame, finds_no_depth_where_nothing_was_drawn) {
  DepthBuffer depth(width, height, 0.0f, 0);  // reversed: 0 is the far end
  const glm::dvec2 pixel(10, 12);
  const glm::dvec3 point = camera_.origin_at(pixel) + 7.0 * camera_.ray_at(pixel);
  const glm::dvec4 clip = camera_.clip_from_local * glm::dvec4(point, 1.0);
  depth.set(10, 12, static_cast<float>(clip.z / clip.w), 0);
  Executor executor(2);
  std::vector<float> depths;
  fill_depths(executor, depth.image(), camera_, depths);
  ASSERT_EQ(depths.size(), size_t{width} * height);
  EXPECT_NEAR(depths[12 * width + 10], 7.0f, 1e-4f);
  EXPECT_EQ(std::ranges::count(depths, 0.0f), ptrdiff_t{width * height - 1});
}

INSTANTIATE_TEST_SUITE_P(, CameraOfAFrame, testing::Values(true, false),
                         [](const auto& test) { return test.param ? "perspective" : "orthographic"; });

TEST(PerspectiveCamera, places_nothing_that_is_behind_the_eye) {
  const FrameCamera camera(view_of(true), width, height);
  EXPECT_FALSE(camera.place(eye - (target - eye)));
  EXPECT_TRUE(camera.place(target));
}

}  // namespace
}  // namespace sideray::rt::frame_camera_test
