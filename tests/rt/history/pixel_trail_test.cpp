// Tests the reprojection of pixels to the previous frame: a camera moves past a floor and a wall, and every answer is
// compared with the projection of the pixel's point.
#include "rt/history/pixel_trail.h"

#include <gtest/gtest.h>

#include "rt/base/view_rays.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::pixel_trail_test {
namespace {

using namespace test;

constexpr uint32_t width = 96, height = 64;
constexpr double floor_y = 0.0, wall_z = -6.0, post_x = 0.4;

// Returns the distance of a ray's first hit: the floor, the wall behind it, or the post in front of both.
double nearest(const Ray& ray) {
  const glm::dvec3 from(ray.origin), d(ray.direction);
  double least = 1e9;
  const auto meet = [&](double t, bool is_there) {
    if (t > 0.01 && t < least && is_there) least = t;
  };
  const double floor = (floor_y - from.y) / d.y, wall = (wall_z - from.z) / d.z, post = (-3.0 - from.z) / d.z;
  meet(floor, floor * d.z + from.z > wall_z);
  meet(wall, true);
  meet(post, std::abs(from.x + post * d.x) < post_x && from.y + post * d.y < 2.0 && from.y + post * d.y > 0.0);
  return least;
}

struct View {
  TraceView view;
  DepthBuffer depth{width, height, 0.0f, 0};
  std::vector<glm::dvec3> points;

  explicit View(const TraceView& of) : view(of) {
    const ViewRays rays(view, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const Ray ray = rays.ray(x, y);
        const glm::dvec3 point = glm::dvec3(ray.origin) + glm::dvec3(ray.direction) * nearest(ray);
        const glm::dvec4 clip = view.clip_from_local * glm::dvec4(point, 1.0);
        depth.set(x, y, static_cast<float>(clip.z / clip.w), 0);
        points.push_back(point);
      }
  }
  glm::dvec2 place(glm::dvec3 point) const {
    const glm::dvec4 clip = view.clip_from_local * glm::dvec4(point, 1.0);
    return (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * glm::dvec2(width, height) - 0.5;
  }
};

TraceView from(glm::dvec3 eye, bool perspective_view, glm::dvec3 along = {0.1, -0.5, -2.0}) {
  const glm::dvec3 target = eye + along;
  return perspective_view ? perspective(eye, target, 0.9, double{width} / height)
                          : orthographic(eye, target, 2.0, double{width} / height);
}

class Trail : public testing::TestWithParam<bool> {};

TEST_P(Trail, finds_the_pixel_that_showed_the_point) {
  Executor executor(2);
  PixelTrail trail;
  View then(from({0, 1.5, 0}, GetParam()));
  trail.begin({then.view, then.depth.image(), {width, height}, {}, false}, executor);
  size_t found = 0, all = 0;
  for (int f = 1; f <= 6; ++f) {
    const View now(from({0.07 * f, 1.5 + 0.02 * f, -0.05 * f}, GetParam()));
    trail.begin({now.view, now.depth.image(), {width, height}, {}, true}, executor);
    ASSERT_FALSE(trail.same_view());
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; x += frame_tile_size) {
        const uint32_t* row = trail.from(x, y);
        for (uint32_t i = 0; i < frame_tile_size; ++i) {
          const size_t pixel = size_t{y} * width + x + i;
          const glm::dvec2 place = then.place(now.points[pixel]);
          const bool inside = place.x >= 0 && place.y >= 0 && place.x <= width - 1 && place.y <= height - 1;
          all += inside;
          if (row[i] == PixelTrail::nowhere) continue;
          ++found;
          ASSERT_TRUE(inside) << x + i << ' ' << y;
          const glm::dvec2 at(row[i] % width, row[i] / width);
          ASSERT_LE(std::abs(at.x - place.x), 1.001) << x + i << ' ' << y;
          ASSERT_LE(std::abs(at.y - place.y), 1.001) << x + i << ' ' << y;
          // The pixel showed the same surface: its point then lies within a few pixels of this point.
          ASSERT_LT(glm::distance(then.points[row[i]], now.points[pixel]), 0.5) << x + i << ' ' << y;
        }
      }
    then = now;
  }
  EXPECT_GT(found, all * 95 / 100);
}

// Disoccluded points have no previous pixel.
TEST_P(Trail, knows_nothing_of_what_was_hidden) {
  Executor executor(2);
  PixelTrail trail;
  // Both look at the post.
  const View then(from({-0.8, 1.2, 0}, GetParam(), {0.8, -0.3, -3.0})), now(from({0.8, 1.2, 0}, GetParam(), {-0.8, -0.3, -3.0}));
  trail.begin({then.view, then.depth.image(), {width, height}, {}, false}, executor);
  trail.begin({now.view, now.depth.image(), {width, height}, {}, true}, executor);
  size_t hidden = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; x += frame_tile_size) {
      const uint32_t* row = trail.from(x, y);
      for (uint32_t i = 0; i < frame_tile_size; ++i) {
        const glm::dvec3 point = now.points[size_t{y} * width + x + i];
        const glm::dvec2 place = glm::floor(then.place(point) + 0.5);
        if (place.x < 2 || place.y < 2 || place.x >= width - 2 || place.y >= height - 2) continue;
        bool was_post = true;  // the post with a border, which another surface was behind
        for (int dy = -2; dy <= 2; ++dy)
          for (int dx = -2; dx <= 2; ++dx) {
            const size_t at = static_cast<size_t>((place.y + dy) * width + place.x + dx);
            was_post = was_post && std::abs(then.points[at].z + 3.0) < 1e-3;
          }
        if (!was_post || std::abs(point.z + 3.0) < 1e-3) continue;
        ++hidden;
        EXPECT_EQ(row[i], PixelTrail::nowhere) << x + i << ' ' << y;
      }
    }
  EXPECT_GT(hidden, 20u);
}

TEST_P(Trail, stays_where_nothing_moves) {
  Executor executor(1);
  PixelTrail trail;
  const View view(from({0, 1.5, 0}, GetParam()));
  trail.begin({view.view, view.depth.image(), {width, height}, {}, false}, executor);
  trail.begin({view.view, view.depth.image(), {width, height}, {}, true}, executor);
  EXPECT_TRUE(trail.same_view());
  const uint32_t* row = trail.from(32, 7);
  for (uint32_t i = 0; i < frame_tile_size; ++i) EXPECT_EQ(row[i], 7 * width + 32 + i);
}

// Pixels without a surface, and those that show another one, were nowhere.
TEST_P(Trail, stays_only_with_its_surface) {
  Executor executor(1);
  PixelTrail trail;
  View view(from({0, 1.5, 0}, GetParam()));
  view.depth.set(33, 7, 0.0f, 0);
  trail.begin({view.view, view.depth.image(), {width, height}, {}, false}, executor);
  view.depth.set(34, 7, 0.9f, 0);
  trail.begin({view.view, view.depth.image(), {width, height}, {}, true}, executor);
  ASSERT_TRUE(trail.same_view());
  EXPECT_NE(*trail.from(32, 7), PixelTrail::nowhere);
  EXPECT_EQ(*trail.from(33, 7), PixelTrail::nowhere) << "empty in both frames";
  EXPECT_EQ(*trail.from(34, 7), PixelTrail::nowhere) << "something came before it";
}

// A pixel at an edge finds its surface in any of the four pixels around its place.
TEST_P(Trail, finds_an_edge_beside_the_nearest_pixel) {
  Executor executor(2);
  PixelTrail trail;
  const auto is_post = [](const View& view, size_t pixel) { return std::abs(view.points[pixel].z + 3.0) < 1e-3; };
  View then(from({0, 1.5, 0}, GetParam()));
  trail.begin({then.view, then.depth.image(), {width, height}, {}, false}, executor);
  size_t edges = 0;
  for (int f = 1; f <= 6; ++f) {
    const View now(from({0.07 * f, 1.5 + 0.02 * f, -0.05 * f}, GetParam()));
    trail.begin({now.view, now.depth.image(), {width, height}, {}, true}, executor);
    for (size_t pixel = 0; pixel < now.points.size(); ++pixel) {
      const glm::dvec2 place = then.place(now.points[pixel]), part = glm::fract(place);
      const bool is_clear = part.x > 0.01 && part.y > 0.01 && part.x < 0.99 && part.y < 0.99;
      const bool is_inside = place.x >= 0 && place.y >= 0 && place.x <= width - 1 && place.y <= height - 1;
      if (!is_post(now, pixel) || !is_clear || !is_inside) continue;
      const size_t corner = static_cast<size_t>(place.y) * width + static_cast<size_t>(place.x);
      size_t posts = 0;
      for (const size_t at : {corner, corner + 1, corner + width, corner + width + 1}) posts += is_post(then, at);
      if (posts == 0 || posts == 4) continue;
      ++edges;
      const auto x = static_cast<uint32_t>(pixel % width), y = static_cast<uint32_t>(pixel / width);
      EXPECT_NE(*trail.from(x, y), PixelTrail::nowhere) << x << ' ' << y << " in frame " << f;
    }
    then = now;
  }
  EXPECT_GT(edges, 100u);
}

// The local space may get another origin between frames.
TEST_P(Trail, goes_on_where_the_space_moves) {
  Executor executor(2);
  const glm::dvec3 eye{0, 1.5, 0}, next{0.07, 1.52, -0.05}, origin{1024.0, 0.0, -2048.0};
  const View then(from(eye, GetParam())), now(from(next, GetParam()));
  PixelTrail stays, moves;
  for (PixelTrail* trail : {&stays, &moves})
    trail->begin({then.view, then.depth.image(), {width, height}, {}, false}, executor);
  stays.begin({now.view, now.depth.image(), {width, height}, {}, true}, executor);
  moves.begin({from(next - origin, GetParam()), now.depth.image(), {width, height}, origin, true}, executor);
  size_t equal = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) equal += *stays.from(x, y) == *moves.from(x, y);
  EXPECT_GT(equal, width * height * 99 / 100) << "apart from rounding";
}

// A cut, or a picture of another size, has no past.
TEST_P(Trail, ends_with_a_cut) {
  Executor executor(1);
  PixelTrail trail;
  const View view(from({0, 1.5, 0}, GetParam()));
  for (const bool follows : {false, true, false}) {
    trail.begin({view.view, view.depth.image(), {width, height}, {}, follows}, executor);
    EXPECT_EQ(trail.follows(trail.step() - 1), follows);
    EXPECT_EQ(trail.same_view(), follows);
  }
  trail.begin({view.view, view.depth.image(), {width, height / 2}, {}, true}, executor);
  EXPECT_FALSE(trail.follows(trail.step() - 1));
}

// A floor that is seen from its edge has depths that differ far more between neighbouring pixels than on other surfaces.
TEST_P(Trail, follows_a_floor_that_is_seen_from_its_edge) {
  Executor executor(2);
  PixelTrail trail;
  const glm::dvec3 along(0.05, -0.05, -2.0);
  const View then(from({0, 0.15, 0}, GetParam(), along)), now(from({0.02, 0.155, -0.03}, GetParam(), along));
  trail.begin({then.view, then.depth.image(), {width, height}, {}, false}, executor);
  trail.begin({now.view, now.depth.image(), {width, height}, {}, true}, executor);
  const auto is_floor = [](const View& view, size_t pixel) { return std::abs(view.points[pixel].y) < 1e-6; };
  size_t steep = 0;
  for (size_t pixel = 0; pixel < now.points.size(); ++pixel) {
    const glm::dvec2 place = then.place(now.points[pixel]);
    if (!is_floor(now, pixel) || place.x < 0 || place.y < 0 || place.x >= width - 1 || place.y >= height - 1) continue;
    const size_t corner = static_cast<size_t>(place.y) * width + static_cast<size_t>(place.x);
    bool all_floor = true;
    for (const size_t at : {corner, corner + 1, corner + width, corner + width + 1})
      all_floor = all_floor && is_floor(then, at);
    if (!all_floor) continue;
    steep += std::abs(then.points[corner].z - then.points[corner + width].z) > 0.2;
    const uint32_t was = *trail.from(static_cast<uint32_t>(pixel % width), static_cast<uint32_t>(pixel / width));
    ASSERT_NE(was, PixelTrail::nowhere) << pixel;
    EXPECT_LE(std::abs(was % width - place.x), 1.0) << pixel;
    EXPECT_LE(std::abs(was / width - place.y), 1.0) << pixel;
  }
  EXPECT_GT(steep, 50u);
}

// Several histories share a trail: each begins the frame, but the trail takes it once.
TEST_P(Trail, takes_a_frame_that_is_begun_twice_once) {
  Executor executor(2);
  PixelTrail trail;
  const View then(from({0, 1.5, 0}, GetParam())), now(from({0.1, 1.5, 0}, GetParam()));
  trail.begin({then.view, then.depth.image(), {width, height}, {}, false, 1}, executor);
  trail.begin({now.view, now.depth.image(), {width, height}, {}, true, 2}, executor);
  const uint64_t step = trail.step();
  trail.begin({now.view, now.depth.image(), {width, height}, {}, true, 2}, executor);
  EXPECT_EQ(trail.step(), step);
  EXPECT_FALSE(trail.same_view());
}

// Steps that are too small to count add up to a movement.
TEST_P(Trail, is_not_fooled_by_small_steps) {
  Executor executor(1);
  PixelTrail trail;
  bool moved = false;
  for (int f = 0; f < 40; ++f) {
    const View view(from({1e-6 * f, 1.5, 0}, GetParam()));
    trail.begin({view.view, view.depth.image(), {width, height}, {}, f > 0}, executor);
    moved = moved || (f > 0 && !trail.same_view());
  }
  for (int f = 0; f < 40; ++f) {
    const View view(from({4e-5 + 1e-5 * f, 1.5, 0}, GetParam()));
    trail.begin({view.view, view.depth.image(), {width, height}, {}, true}, executor);
    moved = moved || !trail.same_view();
  }
  EXPECT_TRUE(moved);
}

INSTANTIATE_TEST_SUITE_P(, Trail, testing::Values(true, false),
                         [](const auto& test) { return test.param ? "perspective" : "orthographic"; });

}  // namespace
}  // namespace sideray::rt::pixel_trail_test
