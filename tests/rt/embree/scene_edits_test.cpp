// Tests that a tracer that follows a scene through random edits gives the same results as a new one.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "model/random_edits.h"
#include "rt/base/executor.h"
#include "rt/poses/angle_cull.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::test {
namespace {

using model::test::RandomEdits;

constexpr uint32_t size = 48;

std::vector<sideray_ray> rays_into(uint32_t seed) {
  std::mt19937 random(seed);
  const auto unit = [&] { return static_cast<double>(random() % 4096) / 4096.0; };
  std::vector<sideray_ray> rays(400);
  for (sideray_ray& ray : rays) {
    const glm::dvec3 from(8.0 * unit() - 4.0, 8.0 * unit() - 4.0, 6.0);
    const glm::dvec3 to(4.0 * unit() - 2.0, 4.0 * unit() - 2.0, 4.0 * unit() - 2.0);
    for (int c = 0; c < 3; ++c) {
      ray.origin[c] = from[c];
      ray.direction[c] = static_cast<float>(to[c] - from[c]);
    }
    ray.t_near = 0.0f;
    ray.t_far = INFINITY;
  }
  return rays;
}

void expect_same_hits(Tracer& edited, Tracer& fresh, const RandomEdits& edits, uint32_t seed) {
  const std::vector<sideray_ray> rays = rays_into(seed);
  constexpr uint32_t layers = 3;
  std::vector<sideray_hit> a(rays.size() * layers), b(a.size());
  for (const sideray_ray_set set : {SIDERAY_RAYS_OPAQUE, SIDERAY_RAYS_TRANSLUCENT}) {
    edited.trace_rays(set, rays, layers, a.data());
    fresh.trace_rays(set, rays, layers, b.data());
    for (size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].surface_id, b[i].surface_id) << i;
      ASSERT_EQ(std::bit_cast<uint64_t>(a[i].distance), std::bit_cast<uint64_t>(b[i].distance)) << i;
      ASSERT_EQ(a[i].primitive, b[i].primitive);
      if (a[i].surface_id == 0) continue;
      ASSERT_TRUE(edits.instances().contains(a[i].instance));
      ASSERT_EQ(edits.instances().at(a[i].instance).surface_id, a[i].surface_id) << "hits report names";
    }
  }
}

LayerCache cache_of(Tracer& tracer) {
  TestFrame frame(perspective({0, 0, 7}, {0, 0, 0}, 0.9, 1.0), size, size, 3);
  LayerCache cache;
  tracer.trace_cache(frame.get(), cache);
  return cache;
}

TEST(SceneEdits, LeaveTheAnswersOfASceneBuiltFromNothing) {
  const std::vector<sideray_light> lights{point_light({0, 0, 5}, 20.0f), directional_light({0, -1, -1}, 1.0f)};
  size_t layers_met = 0;
  for (uint32_t seed = 1; seed <= 2; ++seed) {
    RandomEdits edits(seed);
    edits.scene().set_lights(lights.data(), lights.size());
    Tracer edited({.threads = 2, .isa = ""});
    for (int commit = 0; commit < 5; ++commit) {
      for (int i = 0; i < 25; ++i) edits.step();
      edits.scene().commit();
      edited.set_scene(edits.scene().snapshot());
      model::Scene built;
      edits.build(built);
      built.set_lights(lights.data(), lights.size());
      built.commit();
      Tracer fresh({.threads = 2, .isa = ""});
      fresh.set_scene(built.snapshot());
      expect_same_hits(edited, fresh, edits, seed);
      if (HasFatalFailure()) return;
      const LayerCache a = cache_of(edited), b = cache_of(fresh);
      EXPECT_EQ(a.distance, b.distance);
      EXPECT_EQ(a.surface_id, b.surface_id);
      EXPECT_EQ(a.radiance, b.radiance);
      layers_met += static_cast<size_t>(
          std::count_if(a.surface_id.begin(), a.surface_id.end(), [](uint32_t id) { return id != 0; }));
    }
  }
  EXPECT_GT(layers_met, 200u);
}

sideray_instance_desc instance_at(double x, uint32_t mesh, uint32_t material) {
  sideray_instance_desc d{};
  d.mesh = mesh;
  d.material = material;
  for (const int i : {0, 4, 8}) d.world_from_object[i] = 1.0;
  d.world_from_object[9] = x;
  d.surface_id = 1;
  d.visibility = SIDERAY_VISIBLE_ALL;
  return d;
}

// Three spheres' worth of bounds at the limit of the cull angle: what is remembered of one is not taken for another's.
TEST(SceneEdits, TheCullAngleRemembersByName) {
  TestScene scene;
  scene.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, plain_material());
  const double far = 40.0, near = 20.0;
  const sideray_instance_desc descs[] = {instance_at(far, 1, 1), instance_at(near, 1, 1)};
  uint32_t names[2];
  scene.scene.add_instances(descs, 2, names);
  Executor executor(1);
  AngleCull cull;
  const auto first = scene.commit();
  // At the origin lies the eye: of the three, the second alone is too small.
  const double radius = std::sqrt(2.0);
  const auto angle_at = [&](double distance) {
    return static_cast<float>(2.0 * std::asin(radius / distance) * 180.0 / 3.14159265358979);
  };
  cull.update(*first, angle_at(30.0), glm::vec3(0, 0, 1), executor);
  ASSERT_EQ(cull.culled(), (std::vector<uint8_t>{0, 1, 0}));
  // Between the two limits everything stays what it is, whatever its index is now.
  scene.scene.remove_instances(&names[0], 1);
  const auto second = scene.commit();
  cull.update(*second, angle_at(near * 1.05), glm::vec3(0, 0, 1), executor);
  EXPECT_EQ(cull.culled(), (std::vector<uint8_t>{0, 0}));
}

}  // namespace
}  // namespace sideray::rt::test
