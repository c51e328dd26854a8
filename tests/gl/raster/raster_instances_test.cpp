// Tests many instances in the rasterizer: culling, and reuse between snapshots.
#include <algorithm>
#include <cmath>
#include <random>

#include "gl/gl_contexts.h"
#include "gl/raster/raster_scene_builder.h"
#include "gl/scene/raster_scene.h"
#include "gl/scene/raster_view.h"

namespace sideray::gl::tests::raster_instances_test {
namespace {

constexpr uint32_t width = 160, height = 100;

glm::dvec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

sideray_camera random_camera(std::mt19937& random, bool orthographic) {
  std::uniform_real_distribution<double> place(-50, 50), angle(0.2, 2.6);
  sideray_camera camera = camera_at({place(random), place(random), place(random)}, random_direction(random));
  camera.yfov = static_cast<float>(angle(random));
  camera.orthographic = orthographic;
  camera.half_height = static_cast<float>(10 * angle(random));
  camera.z_far = orthographic ? 1000.0f : 0.0f;
  return camera;
}

// Width and height in pixels of what a view shows of a sphere, from points all over it.
glm::dvec2 extent(const RasterView& view, glm::dvec3 center, double radius, std::mt19937& random) {
  glm::dvec2 low(INFINITY), high(-INFINITY);
  for (int i = 0; i < 300; ++i) {
    const glm::dvec4 clip = view.clip_from_local * glm::dvec4(center + radius * random_direction(random), 1.0);
    const glm::dvec2 p = glm::dvec2(clip) / clip.w * 0.5 * glm::dvec2(width, height);
    low = glm::min(low, p), high = glm::max(high, p);
  }
  return high - low;
}

TEST(TooSmall, IsWhatFitsIntoHalfAPixelWhereverItIsSeen) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> along(-1.3, 1.3), log_distance(0, 3), pixels(0.02, 1.5);
  for (int i = 0; i < 600; ++i) {
    const bool orthographic = i % 3 == 0;
    sideray_camera camera = random_camera(random, orthographic);
    if (i % 2 == 1) camera.fx_per_fy = 2.5f, camera.shift_x = 0.25f, camera.shift_y = -0.125f;
    const RasterView view = make_raster_view(camera, glm::vec2(0), {width, height});
    // Somewhere in the picture or beside it, of a size that is a pixel or less about there.
    const double depth = std::pow(10.0, log_distance(random));
    const double half = orthographic ? double{view.half_height} : depth * std::tan(0.5 * double{view.yfov});
    const glm::dmat4 local_from_view = glm::inverse(view.view_from_local);
    const glm::dvec3 center =
        local_from_view * glm::dvec4(along(random) * half * width / height, along(random) * half, -depth, 1.0);
    const double wanted = pixels(random) * 2.0 * half / height;  // in pixels where the picture's middle is
    const glm::dvec3 side(0.5 * wanted / std::sqrt(3.0));
    const model::Bounds bounds{glm::vec3(center - side), glm::vec3(center + side)};
    const glm::dvec2 seen = extent(view, glm::dvec3(bounds.center()), double{bounds.radius()}, random);
    if (is_too_small(view, height, bounds)) {
      EXPECT_LE(std::max(seen.x, seen.y), 0.505) << i;
    }
    if (std::max(seen.x, seen.y) < 0.1) {
      EXPECT_TRUE(is_too_small(view, height, bounds)) << i;
    }
  }
}

TEST(TooSmall, NeverWhatTheEyeIsInOrHasBeside) {
  const RasterView view = make_raster_view(camera_at({0, 0, 5}), glm::vec2(0), {width, height});
  EXPECT_FALSE(is_too_small(view, height, {glm::vec3(-1e-6f, -1e-6f, 5.0f - 1e-6f), glm::vec3(1e-6f, 1e-6f, 5.0f)}));
  EXPECT_FALSE(is_too_small(view, height, {glm::vec3(7.0f, 0.0f, 5.0f), glm::vec3(7.0001f, 0.0001f, 5.0001f)}));
  EXPECT_TRUE(is_too_small(view, height, {glm::vec3(0.0f), glm::vec3(0.001f)}));
}

// Squares all around the eye; `order` is theirs in the scene.
std::shared_ptr<const model::Snapshot> squares(const std::vector<uint32_t>& order, double time_s = 0) {
  SceneBuilder builder;
  sideray_material_desc both_sides = plain_material();
  both_sides.double_sided = 1;
  const uint32_t plain = builder.material(both_sides);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-12, 12), log_size(-3.0, 0.0);
  struct Square {
    glm::dvec3 center;
    double size;
  };
  std::vector<Square> all;
  for (size_t i = 0; i < order.size(); ++i) {
    const glm::dvec3 center(place(random), place(random), place(random));
    all.push_back({center, std::pow(10.0, log_size(random))});
  }
  for (const uint32_t i : order) builder.quad(plain, all[i].center, all[i].size, i + 1);
  builder.scene.set_time(time_s, time_s);
  return builder.commit();
}

std::vector<uint32_t> numbers(uint32_t count) {
  std::vector<uint32_t> result(count);
  for (uint32_t i = 0; i < count; ++i) result[i] = i;
  return result;
}

class RasterInstances : public EveryContext {
 protected:
  void draw(Rasterizer& rasterizer, const std::shared_ptr<const model::Snapshot>& snapshot, glm::dvec3 target) {
    rasterizer.set_scene(snapshot);
    rasterizer.resize(width, height);
    rasterizer.set_view(rasterizer.make_view(camera_at({0, 0, 0}, target), glm::vec2(0)));
    rasterizer.gbuffer();
  }
};

// The grouping of instances into blocks and draws does not change the picture.
TEST_P(RasterInstances, TheirOrderChangesNoPixel) {
  std::vector<uint32_t> order = numbers(900);
  Rasterizer one(gl()), other(gl());
  const auto sorted = squares(order);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  const auto shuffled = squares(order);
  for (const glm::dvec3 target : {glm::dvec3(0, 0, -5), glm::dvec3(1, 0.5, 5), glm::dvec3(-1, 3, -4)}) {
    draw(one, sorted, target);
    draw(other, shuffled, target);
    EXPECT_EQ(one.read_depth(), other.read_depth());
    const Rasterizer::GBufferImages a = one.read_gbuffer(), b = other.read_gbuffer();
    size_t drawn = 0;
    for (size_t i = 0; i < a.ids.size(); ++i) {
      EXPECT_EQ(a.ids[i], b.ids[i]);
      drawn += a.ids[i].x != 0;
    }
    EXPECT_GT(drawn, 200u);
  }
}

TEST_P(RasterInstances, OnlyAChangeOfSurfacesIsUploaded) {
  RasterScene scene(gl());
  const std::vector<uint32_t> order = numbers(100);
  const auto first = squares(order, 1.0);
  scene.set_snapshot(first);
  EXPECT_FALSE(scene.kept_surfaces());
  auto later = std::make_shared<model::Snapshot>(*first);
  later->time_s = 2.0;
  scene.set_snapshot(later);
  EXPECT_TRUE(scene.kept_surfaces());
  EXPECT_EQ(scene.snapshot().time_s, 2.0);
  auto moved = std::make_shared<model::Snapshot>(*later);
  moved->instances[7].local_from_object[3].x += 1.0f;
  scene.set_snapshot(moved);
  EXPECT_FALSE(scene.kept_surfaces());
  auto painted = std::make_shared<model::Snapshot>(*moved);
  painted->materials[0].desc.base_color[0] = 0.5f;
  scene.set_snapshot(painted);
  EXPECT_FALSE(scene.kept_surfaces());
  auto bent = std::make_shared<model::Snapshot>(*painted);
  bent->meshes[0] = std::make_shared<model::Mesh>(*bent->meshes[0]);
  scene.set_snapshot(bent);
  EXPECT_FALSE(scene.kept_surfaces());
}

TEST_P(RasterInstances, WhatIsKeptIsDrawnAsWhatIsUploaded) {
  const auto first = squares(numbers(200), 1.0);
  auto later = std::make_shared<model::Snapshot>(*first);
  later->time_s = 2.0;
  Rasterizer kept(gl()), fresh(gl());
  draw(kept, first, {0, 0, -5});
  draw(kept, later, {0, 0, -5});
  draw(fresh, later, {0, 0, -5});
  EXPECT_EQ(kept.read_depth(), fresh.read_depth());
}

INSTANTIATE_TEST_SUITE_P(Contexts, RasterInstances, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace sideray::gl::tests::raster_instances_test
