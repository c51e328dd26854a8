// Compares masks and visible fractions of objects with all triangles in double precision.
#include "rt/truth/object_truth.h"

#include <gtest/gtest.h>

#include "rt/truth/brute_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

constexpr double surely = 1e-5;

struct TracedObjects {
  std::vector<ObjectTruth> truths;
  std::vector<uint32_t> object_of_surface;  // indexed by surface id
};

// Every `surfaces_of_object` surfaces are an object, the first of them object 0.
TracedObjects objects_of(const std::shared_ptr<const model::Snapshot>& snapshot, const BruteCamera& camera,
             uint32_t surfaces_of_object = 1, uint32_t samples_per_side = 1, bool hidden_by_opaque = false,
             uint32_t threads = 1) {
  Tracer tracer({.threads = threads, .isa = ""});
  tracer.set_scene(snapshot);
  ObjectTruthRequest request;
  request.view = camera.view();
  request.view.clip_from_local = glm::translate(request.view.clip_from_local, snapshot->origin);
  request.view.local_from_clip = glm::translate(glm::dmat4(1.0), -snapshot->origin) * request.view.local_from_clip;
  request.width = camera.width, request.height = camera.height;
  request.samples_per_side = samples_per_side;
  request.hidden_by_opaque = hidden_by_opaque;
  TracedObjects traced;
  traced.object_of_surface.resize(snapshot->instances.size() + 1);
  for (const model::Instance& instance : snapshot->instances) {
    const uint32_t object = (instance.surface_id - 1) / surfaces_of_object;
    traced.object_of_surface[instance.surface_id] = object;
    request.object_of.push_back(object);
    request.objects = std::max(request.objects, object + 1);
  }
  traced.truths = tracer.trace_objects(request);
  return traced;
}

// Pixels of the picture, row by row from the top.
std::vector<bool> decoded_mask(const ObjectMask& mask, const BruteCamera& camera) {
  std::vector<bool> pixels(size_t{camera.width} * camera.height);
  size_t at = 0;
  bool inside = false;
  for (const uint32_t run : mask.runs) {
    for (uint32_t k = 0; k < run; ++k, ++at)
      pixels.at(at % camera.height * camera.width + at / camera.height) = inside;
    inside = !inside;
  }
  EXPECT_EQ(at, pixels.size());
  return pixels;
}

void expect_box(const ObjectMask& mask, const BruteCamera& camera) {
  const std::vector<bool> pixels = decoded_mask(mask, camera);
  glm::uvec2 low(1u << 30), high(0);
  uint32_t count = 0;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x)
      if (pixels[size_t{y} * camera.width + x])
        low = glm::min(low, {x, y}), high = glm::max(high, {x, y}), ++count;
  EXPECT_EQ(mask.pixels, count);
  EXPECT_EQ(mask.corner, count == 0 ? glm::uvec2(0) : low);
  EXPECT_EQ(mask.size, count == 0 ? glm::uvec2(0) : high - low + 1u);
}

// Holds, by all triangles, which objects a ray hits and which it shows.
struct Expected {
  std::vector<bool> met, visible;
  double margin;
};

Expected expected_objects(const BruteScene& brute, const TracedObjects& traced, const BruteCamera& camera, double x, double y,
                          bool hidden_by_opaque) {
  const DoubleRay ray = camera.ray(x, camera.height - y);
  const SurfacesMet hits = brute.hits(ray, camera.ray_near(ray), camera.ray_far(ray));
  Expected e{std::vector<bool>(traced.truths.size()), std::vector<bool>(traced.truths.size()), hits.margin};
  bool hidden = false;
  for (const SurfaceMet& hit : hits.all) {
    const uint32_t object = traced.object_of_surface[hit.surface];
    e.met[object] = true;
    if (!hidden) e.visible[object] = true;
    hidden |= !hidden_by_opaque || !hit.translucent;
  }
  return e;
}

TEST(ObjectTruth, masks_are_what_all_triangles_say) {
  for (const bool orthographic : {false, true})
    for (const bool hidden_by_opaque : {false, true}) {
      BruteScene brute;
      brute.add_random(7, 60);
      const BruteCamera camera{
          .width = 47, .height = 35, .orthographic = orthographic, .extent = orthographic ? 2.2 : 0.5};
      const TracedObjects traced = objects_of(brute.scene.commit(), camera, 3, 1, hidden_by_opaque);
      ASSERT_EQ(traced.truths.size(), 20u);
      std::vector<std::vector<bool>> amodal, visible;
      for (const ObjectTruth& truth : traced.truths) {
        expect_box(truth.amodal, camera), expect_box(truth.visible, camera);
        amodal.push_back(decoded_mask(truth.amodal, camera)), visible.push_back(decoded_mask(truth.visible, camera));
      }
      int compared = 0, hidden = 0;
      for (uint32_t y = 0; y < camera.height; ++y)
        for (uint32_t x = 0; x < camera.width; ++x) {
          const Expected e = expected_objects(brute, traced, camera, x + 0.5, y + 0.5, hidden_by_opaque);
          if (e.margin < surely) continue;
          ++compared;
          for (size_t object = 0; object < traced.truths.size(); ++object) {
            EXPECT_EQ(amodal[object][size_t{y} * camera.width + x], e.met[object]) << object << ' ' << x << ' ' << y;
            EXPECT_EQ(visible[object][size_t{y} * camera.width + x], e.visible[object]) << object << ' ' << x << ' ' << y;
            hidden += e.met[object] && !e.visible[object];
          }
        }
      EXPECT_GT(compared, 1550);  // of 1645
      EXPECT_GT(hidden, 300);
    }
}

TEST(ObjectTruth, fractions_are_counted_on_a_grid_within_the_pixels) {
  BruteScene brute;
  brute.add_random(11, 24, true);
  const BruteCamera camera{.width = 19, .height = 13, .extent = 0.5};
  for (const uint32_t n : {1u, 2u, 3u}) {
    const TracedObjects traced = objects_of(brute.scene.commit(), camera, 2, n);
    std::vector<uint64_t> met(traced.truths.size()), visible(traced.truths.size());
    uint64_t unsure = 0;
    for (uint32_t y = 0; y < n * camera.height; ++y)
      for (uint32_t x = 0; x < n * camera.width; ++x) {
        const Expected e = expected_objects(brute, traced, camera, (x + 0.5) / n, (y + 0.5) / n, false);
        unsure += e.margin < 1e-6;
        for (size_t object = 0; object < met.size(); ++object) met[object] += e.met[object], visible[object] += e.visible[object];
      }
    ASSERT_LE(unsure, 2u);
    for (size_t object = 0; object < met.size(); ++object) {
      const ObjectTruth& truth = traced.truths[object];
      EXPECT_NEAR(static_cast<double>(truth.amodal_samples), static_cast<double>(met[object]), static_cast<double>(unsure));
      EXPECT_NEAR(static_cast<double>(truth.visible_samples), static_cast<double>(visible[object]), static_cast<double>(unsure));
      if (n == 1) {
        EXPECT_EQ(truth.amodal.pixels, truth.amodal_samples);
        EXPECT_EQ(truth.visible.pixels, truth.visible_samples);
      }
    }
  }
}

// Boxes that stand on a table touch it with their bottoms: the table alone has no holes there.
TEST(ObjectTruth, what_lies_on_another_surface_leaves_no_hole_in_it) {
  for (const bool box_first : {false, true}) {
    TestScene scene;
    sideray_material_desc single = plain_material();
    single.double_sided = 0;
    const auto add_box = [&] { return Triangles::box({-1, -1, -5}, {1, 1, -4}).add_to(scene, single); };
    uint32_t box = box_first ? add_box() : 0;
    const uint32_t table = scene.quad({0, 0, -5}, {3, 0, 0}, {0, 3, 0}, single);
    if (!box_first) box = add_box();
    const BruteCamera camera{.width = 16, .height = 16, .extent = 0.5};
    const TracedObjects traced = objects_of(scene.commit(), camera);
    EXPECT_EQ(traced.truths[table - 1].amodal.pixels, 256u);
    EXPECT_EQ(traced.truths[table - 1].visible.pixels + traced.truths[box - 1].visible.pixels, 256u);
    EXPECT_EQ(traced.truths[box - 1].visible.pixels, traced.truths[box - 1].amodal.pixels);
  }
}

// More surfaces than one round finds, at one distance and behind one another.
TEST(ObjectTruth, no_surface_is_one_too_many) {
  for (const float step : {0.0f, 0.01f})
    for (const bool translucent : {false, true}) {
      TestScene scene;
      for (int i = 0; i < 40; ++i)
        scene.quad({0, 0, -3 - step * static_cast<float>(i)}, {3, 0, 0}, {0, 3, 0},
                   translucent ? blended(glm::vec3(0.5f), 0.5f) : plain_material());
      const BruteCamera camera{.width = 8, .height = 8};
      const TracedObjects traced = objects_of(scene.commit(), camera);
      for (uint32_t i = 0; i < 40; ++i) {
        EXPECT_EQ(traced.truths[i].amodal.pixels, 64u);
        EXPECT_EQ(traced.truths[i].visible.pixels, i == 0 ? 64u : 0u);
      }
    }
}

TEST(ObjectTruth, is_the_same_for_any_number_of_threads) {
  BruteScene brute;
  brute.add_random(3, 30);
  const auto snapshot = brute.scene.commit();
  const BruteCamera camera{.width = 70, .height = 50, .extent = 0.5};
  const TracedObjects one = objects_of(snapshot, camera, 1, 2, false, 1), three = objects_of(snapshot, camera, 1, 2, false, 3);
  for (size_t i = 0; i < one.truths.size(); ++i) {
    EXPECT_EQ(one.truths[i].visible.runs, three.truths[i].visible.runs);
    EXPECT_EQ(one.truths[i].amodal.runs, three.truths[i].amodal.runs);
    EXPECT_EQ(one.truths[i].visible_samples, three.truths[i].visible_samples);
  }
}

}  // namespace
}  // namespace sideray::rt
