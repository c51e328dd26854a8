// Tests still views in which something moves: tiles that see it restart, others keep their samples. Each tile converges
// to the bits of the picture of all positions.
#include "frame/views/view.h"
#include "scenes/content/shapes.h"

namespace sideray::tests::still_tiles_test {
namespace {

using scenes::ContentBuilder;
using scenes::opaque_material;
using scenes::Shape;

constexpr uint32_t width = 480, height = 32, positions = still_positions;

// Returns a long yard, seen from afar, whose objects are in separate tiles.
scenes::Content make_yard() {
  ContentBuilder b("yard");
  const uint32_t stone = b.material("stone", opaque_material({0.6f, 0.55f, 0.5f}, 0.8f));
  const uint32_t mirror = b.material("mirror", opaque_material({0.9f, 0.9f, 0.9f}, 0.05f));
  const uint32_t glass = b.material("glass", scenes::glass_material({0.9f, 1.0f, 0.95f}, 0.0f), scenes::RayTraced::yes);
  b.object("ground", b.mesh(Shape().quad({-14, 0, 3}, {14, 0, 3}, {14, 0, -2}, {-14, 0, -2}), "ground"), stone);
  b.object("wall", b.mesh(Shape().quad({-14, 0, -2}, {14, 0, -2}, {14, 3, -2}, {-14, 3, -2}), "wall"), stone);
  b.object("box", b.mesh(Shape().box({-0.2f, 0.1f, -0.2f}, {0.2f, 0.5f, 0.2f}), "box"), stone, {-5, 0, 0});
  b.object("ball", b.mesh(Shape().sphere({0, 0.5f, 0}, 0.5f, 32), "ball"), mirror, {-1.5, 0, 0});
  b.object("bowl", b.mesh(Shape().sphere({0, 0.5f, 0}, 0.5f, 32), "bowl"), glass, {4, 0, 0});
  b.particles("steam", {-9, 0.1, 0},
              R"({"count": 24, "lifetime": [1, 2], "start": "cone", "radius": 0.1, "cone_deg": 10, "velocity": [0, 0.5, 0],
                  "size": [0.1, 0.3], "alpha": [0, 0.4, 0], "lit": true})");
  b.light("sun", scenes::sun_light({-0.2f, -0.8f, -0.5f}, glm::vec3(2.0f)));
  b.light("lamp", scenes::point_light({8, 0.6, 0}, glm::vec3(2.0f), 1.5f));
  const double eye[3] = {0, 4, 30}, target[3] = {0, 0.5, 0};
  b.camera("afar", scenes::look_at(eye, target, 2.8f));
  return b.take();
}

struct Course {
  uint64_t rays_of_all, rays_after;
  Shown last, alone;
};

// Lets a view converge, changes something, and lets it converge again.
template <typename Change>
Course course_of(View& view, const Change& change) {
  const uint32_t seed = view.options.picture.seed;
  view.draw();
  Course course{view.draw().rays(), 0, {}, {}};
  view.draw(positions - 1);
  EXPECT_EQ(view.draw().rays(), 0u);
  change();
  const Shown changed = view.draw();
  course.rays_after = changed.rays();
  EXPECT_EQ(changed.stats.positions, 1u);
  course.last = view.draw(positions - 1);
  EXPECT_EQ(course.last.stats.positions, positions);
  EXPECT_EQ(view.draw().rays(), 0u);
  course.alone = view.alone(seed);
  return course;
}

TEST(StillTiles, SeeSmokeWhereItIs) {
  View view(make_yard(), width, height);
  view.pose(5.0);
  const Course course = course_of(view, [&] { view.pose(5.1); });
  EXPECT_LT(4 * course.rays_after, course.rays_of_all);
  EXPECT_EQ(course.last.colors, course.alone.colors);
}

// Its shadow and its mirror image are in other tiles.
TEST(StillTiles, SeeAnObjectWhereItMoves) {
  View view(make_yard(), width, height);
  view.options.picture.ambient = 0;
  const Course course = course_of(view, [&] { view.move_object("box", {0.1, 0.05, 0}); });
  EXPECT_LT(10 * course.rays_after, 9 * course.rays_of_all);
  EXPECT_EQ(course.last.colors, course.alone.colors);
}

TEST(StillTiles, SeeALampWhereItLights) {
  View view(make_yard(), width, height);
  view.options.picture.ambient = SIDERAY_AMBIENT_AO;  // where light bounces, it lights the whole yard
  view.pose(5.0);
  const Course course = course_of(view, [&] { view.move_light(1, {0.2, 0, 0.1}); });
  EXPECT_LT(5 * course.rays_after, 4 * course.rays_of_all);
  EXPECT_EQ(course.last.colors, course.alone.colors);
}

// Bounced light brings it to all tiles.
TEST(StillTiles, SeeALampInTheLightThatBounces) {
  View view(make_yard(), width / 2, height / 2);
  view.options.picture.ambient = SIDERAY_AMBIENT_BOUNCE;
  view.pose(5.0);
  const uint32_t seed = [&] {
    view.draw(8);
    view.move_light(1, {0.2, 0, 0.1});
    return view.options.picture.seed;
  }();
  EXPECT_EQ(view.draw(still_positions + 1).colors, view.alone(seed).colors);
}

// While smoke rises only the tiles that show it restart; the others converge as without it.
TEST(SlowStillTiles, BecomeWholeBesideSmokeThatNeverRests) {
  View view(make_yard(), width, height);
  double time_s = 5.0;
  view.pose(time_s);
  const uint32_t seed = view.options.picture.seed;
  view.draw();
  Shown shown;
  uint64_t first = 0;
  for (uint32_t i = 0; i < positions + 2; ++i) {
    view.pose(time_s += 1.0 / 30.0);
    shown = view.draw();
    if (i == 0) first = shown.rays();
    EXPECT_EQ(shown.stats.positions, 1u);
  }
  EXPECT_LT(3 * shown.rays(), first);
  const Shown alone = view.alone(seed);
  size_t equal = 0;
  for (size_t i = 0; i < alone.colors.size(); ++i) equal += shown.colors[i] == alone.colors[i];
  EXPECT_GT(10 * equal, 8 * alone.colors.size());
  view.draw(positions);
  EXPECT_EQ(view.draw().rays(), 0u);
}

}  // namespace
}  // namespace sideray::tests::still_tiles_test
