// Compares layers of refracting surfaces with the composite of the same pixel along refracted rays, which uses no
// cache.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rt/refraction/refraction_scene.h"

namespace sideray::rt::resolved_layers_test {
namespace {

using namespace test;

constexpr uint32_t size = 24;
// Of halfs, twice: once for a layer, once for the composite.
constexpr float half_precision = 2.0f / 1024;

struct Resolved {
  LayerCache cache;
  CompositeImage composite;
  Counters counters;

  float distance(uint32_t x, uint32_t y, uint32_t layer) const { return cache.distance[texel_of(cache, x, y, layer)]; }
  uint32_t id(uint32_t x, uint32_t y, uint32_t layer) const { return cache.surface_id[texel_of(cache, x, y, layer)]; }
  glm::vec3 radiance(uint32_t x, uint32_t y, uint32_t layer) const {
    return rgb(cache.radiance, texel_of(cache, x, y, layer));
  }
};

struct Traced {
  uint32_t layers = 4, threads = 1;
  bool refraction = true;
  float ray_reuse = 0.0f;
  sideray_cache_rate rate = SIDERAY_RATE_FULL;
};

Resolved trace(const std::shared_ptr<const model::Snapshot>& snapshot, const TraceView& view, const Traced& how = {}) {
  Tracer tracer({.threads = how.threads, .isa = ""});
  tracer.set_scene(snapshot);
  TestFrame frame(view, size, size, how.layers);
  frame.request.refraction = how.refraction;
  frame.request.ray_reuse = how.ray_reuse;
  frame.request.cache_rate = how.rate;
  Resolved traced;
  traced.counters = tracer.trace_cache(frame.get(), traced.cache);
  TestFrame straight(view, size, size, 0);
  straight.request.refraction = how.refraction;
  tracer.trace_composite(straight.get(), traced.composite);
  return traced;
}

TraceView forward(glm::dvec3 eye) {
  return perspective(eye, eye + glm::dvec3(0, 0, -1), 0.5, 1.0, 1e-3);
}

constexpr float front_alpha = 0.25f;

// A box of tinted glass that reflects a lamp and its surroundings, with panes in front of it, inside and behind.
struct GlassScene : TestScene {
  uint32_t front, box, inside, behind;
  GlassScene() {
    TiledWall{-9, 6}.add_to(*this);
    environment({0.4f, 0.6f, 0.9f});
    lights({point_light({0.5f, 2, 0}, 20)});
    front = quad({-1, 0, -2}, {0.9f, 0, 0}, {0, 2, 0}, blended({0.9f, 0.2f, 0.1f}, front_alpha));
    box = Triangles::box({-3, -3, -4}, {3, 3, -3}).add_to(*this, solid_glass(1.5f, {0.9f, 0.6f, 0.5f}, 2.0f));
    inside = quad({0, 0.6f, -3.5f}, {0.5f, 0, 0}, {0, 0.3f, 0}, blended({0.1f, 0.9f, 0.2f}, 0.6f));
    behind = quad({0, -0.8f, -5}, {3, 0, 0}, {0, 0.4f, 0}, blended({0.2f, 0.3f, 0.9f}, 0.5f));
  }
};

void expect_near(glm::vec3 value, glm::vec3 expected, const std::string& where) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected[c], half_precision * (expected[c] + 0.05f)) << where;
}

TEST(ResolvedLayers, hold_what_the_composite_of_their_pixel_shows) {
  GlassScene scene;
  const Resolved seen = trace(scene.commit(), forward(glm::dvec3(0)));
  int in_front = 0, alone = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const std::string where = std::to_string(x) + " " + std::to_string(y);
      const uint32_t first = seen.id(x, y, 0) == scene.front ? 1 : 0;
      ASSERT_EQ(seen.id(x, y, first), scene.box) << where;
      EXPECT_LT(seen.distance(x, y, first), 0.0f) << where;
      EXPECT_EQ(seen.distance(x, y, first + 1), 0.0f) << where << ": nothing is behind";
      glm::vec3 expected = seen.radiance(x, y, first);
      if (first == 1) {
        EXPECT_GT(seen.distance(x, y, 0), 0.0f) << where;
        expected = seen.radiance(x, y, 0) * front_alpha + expected * (1 - front_alpha);
      }
      (first == 1 ? in_front : alone)++;
      expect_near(rgb(seen.composite.radiance, size_t{y} * size + x), expected, where);
    }
  EXPECT_GT(in_front, 50);
  EXPECT_GT(alone, 50);
  EXPECT_EQ(seen.counters.layers_refracted, uint64_t{size} * size);
}

// From inside, too, where the surface is a back, and reflects totally beyond the critical angle.
TEST(ResolvedLayers, are_seen_from_inside_as_by_the_composite) {
  TestScene scene;
  TiledWall{-9, 6}.add_to(scene);
  scene.environment({0.4f, 0.6f, 0.9f});
  Triangles::box({-2, -2, -3}, {2, 2, 1}).add_to(scene, solid_glass(1.33f, {0.9f, 0.7f, 0.3f}, 2.0f));
  const Resolved seen = trace(scene.commit(), forward({0.2, -0.1, 0}));
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      EXPECT_LT(seen.distance(x, y, 0), 0.0f);
      expect_near(seen.radiance(x, y, 0), rgb(seen.composite.radiance, size_t{y} * size + x), std::to_string(x));
    }
}

TEST(ResolvedLayers, surfaces_beyond_the_cache_stay_with_the_rasterizer) {
  GlassScene scene;
  const Resolved seen = trace(scene.commit(), forward(glm::dvec3(0)), {.layers = 1});
  int unresolved = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      if (seen.id(x, y, 0) != scene.front) continue;
      EXPECT_GT(seen.distance(x, y, 0), 0.0f);
      ++unresolved;
    }
  EXPECT_GT(unresolved, 50);
}

TEST(ResolvedLayers, have_the_same_bits_for_any_number_of_threads) {
  GlassScene scene;
  const auto snapshot = scene.commit();
  for (const float reuse : {0.0f, 1.0f / 64}) {
    const Resolved one = trace(snapshot, forward(glm::dvec3(0)), {.threads = 1, .ray_reuse = reuse});
    const Resolved three = trace(snapshot, forward(glm::dvec3(0)), {.threads = 3, .ray_reuse = reuse});
    EXPECT_EQ(one.cache.radiance, three.cache.radiance);
    EXPECT_EQ(one.cache.distance, three.cache.distance);
  }
}

// Only the surface's own light is reused; the view through it is traced in every pixel.
TEST(ResolvedLayers, reuse_rays_for_what_they_reflect_alone) {
  GlassScene scene;
  const auto snapshot = scene.commit();
  const Resolved all = trace(snapshot, forward(glm::dvec3(0)));
  const Resolved reused = trace(snapshot, forward(glm::dvec3(0)), {.ray_reuse = 1.0f / 64});
  EXPECT_GT(reused.counters.layers_borrowed, 0u);
  EXPECT_LT(reused.counters.rays_shadow, all.counters.rays_shadow);
  for (size_t i = 0; i < all.cache.distance.size(); ++i) {
    EXPECT_EQ(all.cache.distance[i], reused.cache.distance[i]);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb(all.cache.radiance, i)[c], rgb(reused.cache.radiance, i)[c], 0.03f);
  }
}

TEST(ResolvedLayers, cost_nothing_where_nothing_is_refracted) {
  TestScene scene;
  scene.environment({0.4f, 0.6f, 0.9f});
  scene.quad({0, 0, -3}, {1, 0, 0}, {0, 1, 0}, glass());
  Triangles::box({-1, -1, -6}, {1, 1, -5}).add_to(scene, solid_glass(1.0f));
  const auto snapshot = scene.commit();
  const Resolved on = trace(snapshot, forward(glm::dvec3(0))),
                 off = trace(snapshot, forward(glm::dvec3(0)), {.refraction = false});
  EXPECT_EQ(on.cache.radiance, off.cache.radiance);
  EXPECT_EQ(on.cache.distance, off.cache.distance);
  EXPECT_EQ(on.counters.layers_refracted, 0u);
  EXPECT_EQ(on.counters.rays_primary, off.counters.rays_primary);
}

}  // namespace
}  // namespace sideray::rt::resolved_layers_test
