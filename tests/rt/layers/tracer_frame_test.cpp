// Tests which pixels are traced, the contents of cache and composite, and the counters.
#include <gmock/gmock.h>

#include <algorithm>

#include "rt/tracer_scene.h"

namespace sideray::rt::tracer_frame_test {
namespace {

using namespace test;

constexpr double fov = 0.8;

TraceView forward_view(double aspect = 1.0) {
  return perspective({0, 0, 0}, {0, 0, -1}, fov, aspect);
}

// Parallel panes across the view at z = -first - k * gap, wider than it.
std::vector<uint32_t> add_panes(TestScene& scene, uint32_t count, float first, float gap,
                                const sideray_material_desc& material) {
  std::vector<uint32_t> ids;
  for (uint32_t k = 0; k < count; ++k)
    ids.push_back(scene.quad({0, 0, -first - static_cast<float>(k) * gap}, {50, 0, 0}, {0, 50, 0}, material));
  return ids;
}

// Depth of the plane z = -distance in the buffers of forward_view.
float depth_at(double distance) {
  return static_cast<float>(0.1 / distance);
}

TEST(TracerFrame, layers_are_in_ray_order_at_the_right_distance) {
  TestScene scene;
  const std::vector<uint32_t> ids = add_panes(scene, 4, 2.0f, 0.5f, blended({1, 0, 0}, 0.5f));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(forward_view(), 40, 40, 3);
  LayerCache cache;
  const Counters counters = tracer.trace_cache(frame.get(), cache);
  ASSERT_EQ(cache.distance.size(), 3u * 40 * 40);
  const double half = std::tan(0.5 * fov);
  for (uint32_t y = 0; y < 40; ++y)
    for (uint32_t x = 0; x < 40; ++x)
      for (uint32_t k = 0; k < 3; ++k) {
        const glm::dvec3 direction(((x + 0.5) / 20 - 1) * half, ((y + 0.5) / 20 - 1) * half, -1);
        EXPECT_NEAR(static_cast<double>(cache.distance[texel_of(cache, x, y, k)]),
                    (2.0 + 0.5 * k) * glm::length(direction), 2e-6);
        EXPECT_EQ(cache.surface_id[texel_of(cache, x, y, k)], ids[k]);
      }
  EXPECT_EQ(counters.pixels_total, 1600u);
  EXPECT_EQ(counters.pixels_masked, 1600u);
  EXPECT_EQ(counters.rays_primary, 1600u);
  EXPECT_EQ(counters.layers_requested, 4800u);
  EXPECT_EQ(counters.layers_found, 4800u);
  EXPECT_EQ(counters.traversals_wasted, 0u);
}

TEST(TracerFrame, counts_limit_what_is_traced) {
  TestScene scene;
  add_panes(scene, 4, 2.0f, 0.5f, blended({1, 0, 0}, 0.5f));
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(forward_view(), 32, 32, 4, 0);
  for (uint32_t i = 0; i < 7; ++i) frame.depth.set(3 * i, 2 * i, 0.0f, i);  // counts 0 to 6
  frame.depth.set(31, 31, 0.0f, 63);
  LayerCache cache;
  const Counters counters = tracer.trace_cache(frame.get(), cache);
  for (uint32_t i = 0; i < 7; ++i)
    for (uint32_t k = 0; k < 4; ++k)
      EXPECT_EQ(cache.distance[texel_of(cache, 3 * i, 2 * i, k)] > 0.0f, k < i) << i << ' ' << k;
  EXPECT_GT(cache.distance[texel_of(cache, 31, 31, 3)], 0.0f);
  EXPECT_EQ(std::count_if(cache.distance.begin(), cache.distance.end(), [](float d) { return d > 0; }),
            1 + 2 + 3 + 4 + 4 + 4 + 4);
  EXPECT_EQ(counters.pixels_masked, 7u);
  EXPECT_EQ(counters.layers_requested, 22u);
  EXPECT_EQ(counters.layers_found, 22u);

  frame.request.mask = SIDERAY_MASK_STENCIL;  // the value says nothing then
  const Counters stencil = tracer.trace_cache(frame.get(), cache);
  EXPECT_EQ(stencil.pixels_masked, 7u);
  EXPECT_EQ(stencil.layers_found, 28u);
  frame.request.mask = SIDERAY_MASK_NONE;
  EXPECT_EQ(tracer.trace_cache(frame.get(), cache).pixels_masked, 1024u);
}

TEST(TracerFrame, opaque_depth_ends_the_ray) {
  TestScene scene;
  const std::vector<uint32_t> ids = add_panes(scene, 3, 2.0f, 1.0f, blended({1, 0, 0}, 0.5f));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(forward_view(), 32, 32, 4);
  frame.depth.set(3, 4, depth_at(2.001), 63);
  frame.depth.set(9, 4, depth_at(1.999), 63);
  frame.depth.set(20, 30, depth_at(3.999), 63);
  LayerCache cache;
  const Counters counters = tracer.trace_cache(frame.get(), cache);
  EXPECT_EQ(cache.surface_id[texel_of(cache, 3, 4, 0)], ids[0]);
  EXPECT_EQ(cache.distance[texel_of(cache, 3, 4, 1)], 0.0f);
  EXPECT_EQ(cache.distance[texel_of(cache, 9, 4, 0)], 0.0f);
  EXPECT_EQ(cache.surface_id[texel_of(cache, 20, 30, 1)], ids[1]);
  EXPECT_EQ(cache.distance[texel_of(cache, 20, 30, 2)], 0.0f);
  EXPECT_EQ(counters.traversals_wasted, 1u);
  EXPECT_LE(counters.layers_found, counters.layers_requested);
}

TEST(TracerFrame, tiles_of_the_last_frame_are_cleared_and_reported) {
  TestScene scene;
  add_panes(scene, 1, 2.0f, 1.0f, blended({1, 0, 0}, 0.5f));
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame first(forward_view(), 70, 40, 2, 0), second(forward_view(), 70, 40, 2, 0);
  first.depth.set(5, 5, 0.0f, 63), first.depth.set(66, 35, 0.0f, 63);     // tiles (0, 0) and (2, 1)
  second.depth.set(40, 6, 0.0f, 63), second.depth.set(67, 35, 0.0f, 63);  // tiles (1, 0) and (2, 1)
  LayerCache cache;
  CompositeImage image;
  tracer.trace_cache(first.get(), cache);
  tracer.trace_composite(first.get(), image);
  EXPECT_THAT(cache.dirty_tiles, testing::Each(1));  // a new cache goes up whole
  EXPECT_THAT(cache.traced_tiles, testing::ElementsAre(1, 0, 0, 0, 0, 1));
  tracer.trace_cache(second.get(), cache);
  tracer.trace_composite(second.get(), image);
  EXPECT_THAT(cache.traced_tiles, testing::ElementsAre(0, 1, 0, 0, 0, 1));
  EXPECT_THAT(cache.dirty_tiles, testing::ElementsAre(1, 1, 0, 0, 0, 1));
  EXPECT_EQ(cache.traced_tiles, image.traced_tiles);
  EXPECT_EQ(cache.dirty_tiles, image.dirty_tiles);
  for (uint32_t y = 0; y < 40; ++y)
    for (uint32_t x = 0; x < 70; ++x) {
      const bool masked = (x == 40 && y == 6) || (x == 67 && y == 35);
      EXPECT_EQ(cache.distance[texel_of(cache, x, y, 0)] > 0.0f, masked) << x << ' ' << y;
      EXPECT_EQ(rgb(image.transmittance, size_t{y} * 70 + x), glm::vec3(masked ? 0.5f : 1.0f));
    }
}

TEST(TracerFrame, resizing_starts_afresh) {
  TestScene scene;
  add_panes(scene, 1, 2.0f, 1.0f, blended({1, 0, 0}, 0.5f));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  LayerCache cache;
  tracer.trace_cache(TestFrame(forward_view(), 64, 64, 2).get(), cache);
  tracer.trace_cache(TestFrame(forward_view(), 64, 64, 3, 0).get(), cache);
  EXPECT_EQ(cache.layers, 3u);
  EXPECT_THAT(cache.distance, testing::Each(0.0f));
  EXPECT_THAT(cache.dirty_tiles, testing::Each(1));
}

// Glass, tinted, additive, premultiplied and multiplying panes, crossed, with a light and an environment.
void add_mixed_scene(TestScene& scene) {
  sideray_material_desc additive = blended({0.2f, 0.5f, 0.9f}, 0.4f), multiply = blended({0.9f, 0.6f, 0.3f}, 0.5f);
  additive.blend_mode = SIDERAY_BLEND_ADDITIVE;
  multiply.blend_mode = SIDERAY_BLEND_MULTIPLY;
  sideray_material_desc premultiplied = blended({0.3f, 0.3f, 0.1f}, 0.2f);
  premultiplied.blend_mode = SIDERAY_BLEND_PREMULTIPLIED;
  scene.quad({0, 0, -4}, {2, 0, 0.8f}, {0, 2, 0.3f}, glass());
  scene.quad({0.3f, 0, -4}, {2, 0, -0.9f}, {0, 2, 0}, blended({0.8f, 0.3f, 0.2f}, 0.3f));
  scene.quad({0, 0, -5}, {2, 0, 0}, {0, 1, 0.4f}, additive);
  scene.quad({0, 0.4f, -3}, {1, 0, 0}, {0, 1, 0}, multiply);
  scene.quad({-0.4f, 0, -4.5f}, {1, 0, 0}, {0, 3, 0}, premultiplied);
  scene.quad({0, -1.5f, -4}, {4, 0, 0}, {0, 0, -4}, glowing({0.5f, 0.2f, 0.1f}));
  scene.quad({1, 1, -3.5f}, {0.3f, 0, 0}, {0, 0.1f, 0.3f}, plain_material());
  scene.environment({0.4f, 0.5f, 0.6f});
  scene.lights({directional_light({-0.4f, -0.8f, -0.45f}, 3.0f), point_light({1, 2, -2}, 5.0f)});
}

TEST(TracerFrame, same_bits_with_any_number_of_threads) {
  TestScene scene;
  add_mixed_scene(scene);
  const auto snapshot = scene.commit();
  std::vector<LayerCache> caches(3);
  std::vector<CompositeImage> images(3);
  for (uint32_t threads = 1; threads <= 3; ++threads) {
    Tracer tracer({.threads = threads, .isa = ""});
    tracer.set_scene(snapshot);
    EXPECT_EQ(tracer.threads(), threads);
    TestFrame frame(forward_view(1.6), 160, 100, 4);
    tracer.trace_cache(frame.get(), caches[threads - 1]);
    frame.request.max_layers = 0;
    tracer.trace_composite(frame.get(), images[threads - 1]);
  }
  for (size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(caches[0].radiance, caches[i].radiance);
    EXPECT_EQ(caches[0].distance, caches[i].distance);
    EXPECT_EQ(caches[0].surface_id, caches[i].surface_id);
    EXPECT_EQ(images[0].radiance, images[i].radiance);
    EXPECT_EQ(images[0].transmittance, images[i].transmittance);
  }
}

// Composited by hand, in the order of the layers: what a host does with the cache.
TEST(TracerFrame, layers_composited_by_hand_equal_the_composite) {
  TestScene scene;
  scene.environment({0.4f, 0.5f, 0.6f});
  scene.lights({point_light({1, 2, -2}, 20.0f)});
  std::vector<glm::vec4> paint;
  for (uint32_t k = 0; k < 5; ++k) {
    paint.emplace_back(0.2f * static_cast<float>(k), 0.5f, 1.0f - 0.2f * static_cast<float>(k),
                       0.2f + 0.1f * static_cast<float>(k));
    scene.quad({0, 0, -3.0f - 0.3f * static_cast<float>(k)}, {2, 0, 0.1f}, {0, 2, 0},
               blended(glm::vec3(paint[k]), paint[k].w));
  }
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(forward_view(), 48, 48, 8);
  LayerCache cache;
  CompositeImage image;
  tracer.trace_cache(frame.get(), cache);
  frame.request.max_layers = 0;
  tracer.trace_composite(frame.get(), image);
  for (uint32_t y = 0; y < 48; ++y)
    for (uint32_t x = 0; x < 48; ++x) {
      glm::vec3 sum(0), through(1);
      for (uint32_t k = 0; k < 8; ++k) {
        const size_t texel = texel_of(cache, x, y, k);
        if (cache.distance[texel] == 0.0f) break;
        const float alpha = paint[cache.surface_id[texel] - 1].w;
        sum += through * rgb(cache.radiance, texel) * alpha;
        through *= 1.0f - alpha;
      }
      const glm::vec3 traced = rgb(image.radiance, size_t{y} * 48 + x);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(traced[c], sum[c], 1e-3f * sum[c] + 1e-6f);
      EXPECT_NEAR(rgb(image.transmittance, size_t{y} * 48 + x).x, through.x, 1e-3f * through.x);
    }
}

TEST(TracerFrame, surfaces_past_the_limit_vanish_from_the_composite) {
  TestScene scene;
  add_panes(scene, 5, 2.0f, 0.5f, blended({1, 0, 0}, 0.5f));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  CompositeImage image;
  for (const uint32_t layers : {1u, 2u, 4u, 0u}) {
    TestFrame frame(forward_view(), 8, 8, layers);
    tracer.trace_composite(frame.get(), image);
    const float expected = std::pow(0.5f, static_cast<float>(layers ? layers : 5));
    EXPECT_NEAR(rgb(image.transmittance, 27).x, expected, 1e-3f * expected);
  }
}

TEST(TracerFrame, unlimited_means_as_many_as_there_are) {
  TestScene scene;
  add_panes(scene, 70, 2.0f, 0.01f, blended({1, 0, 0}, 0.05f));
  for (int i = 0; i < 25; ++i) scene.quad({0, 0, -4}, {50, 0, 0}, {0, 50, 0}, blended({0, 1, 0}, 0.02f));  // coplanar
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(forward_view(), 8, 8, 0);
  CompositeImage image;
  const Counters counters = tracer.trace_composite(frame.get(), image);
  const float expected = std::pow(0.95f, 70.0f) * std::pow(0.98f, 25.0f);
  for (size_t i = 0; i < 64; ++i) EXPECT_NEAR(rgb(image.transmittance, i).x, expected, 2e-3f * expected);
  EXPECT_EQ(counters.layers_found, 64u * 95);
  EXPECT_LE(counters.layers_found, counters.layers_requested);
}

TEST(TracerFrame, tracing_stops_behind_what_cannot_be_seen_through) {
  TestScene scene;
  add_panes(scene, 3, 2.0f, 0.5f, blended({1, 0, 0}, 1.0f));
  scene.environment(glm::vec3(1));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(forward_view(), 8, 8, 0);
  CompositeImage image;
  const Counters counters = tracer.trace_composite(frame.get(), image);
  EXPECT_EQ(counters.layers_found, 64u);
  EXPECT_LE(counters.rays_reflection, 2u * 64);
}

TEST(TracerFrame, multiplying_surfaces_filter_but_are_never_cached) {
  TestScene scene;
  sideray_material_desc multiply = blended({0.5f, 0.25f, 1.0f}, 1.0f);
  multiply.blend_mode = SIDERAY_BLEND_MULTIPLY;
  add_panes(scene, 3, 1.0f, 0.1f, multiply);
  const uint32_t pane = scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, blended({1, 1, 1}, 0.5f));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  for (const bool all : {false, true}) {
    TestFrame frame(forward_view(), 16, 16, 1);
    frame.request.all_translucent = all;
    LayerCache cache;
    const Counters counters = tracer.trace_cache(frame.get(), cache);
    EXPECT_THAT(cache.surface_id, testing::Each(pane));
    EXPECT_EQ(counters.layers_found, 256u);
  }
  TestFrame frame(forward_view(), 16, 16, 0);
  frame.request.all_translucent = true;
  CompositeImage image;
  tracer.trace_composite(frame.get(), image);
  const glm::vec3 through = rgb(image.transmittance, 100);
  EXPECT_NEAR(through.x, 0.5f * 0.125f, 1e-4f);
  EXPECT_NEAR(through.y, 0.5f / 64.0f, 1e-4f);
  EXPECT_NEAR(through.z, 0.5f, 1e-4f);
}

TEST(TracerFrame, unmarked_surfaces_are_traced_only_on_request) {
  TestScene scene;
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, blended({1, 1, 1}, 0.5f),
             SIDERAY_VISIBLE_ALL & ~uint32_t{SIDERAY_VISIBLE_LAYERS});
  const uint32_t marked = scene.quad({0, 0, -3}, {50, 0, 0}, {0, 50, 0}, blended({1, 1, 1}, 0.5f));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(forward_view(), 8, 8, 2);
  LayerCache cache;
  EXPECT_EQ(tracer.trace_cache(frame.get(), cache).layers_found, 64u);
  EXPECT_EQ(cache.surface_id[texel_of(cache, 3, 3, 0)], marked);
  frame.request.all_translucent = true;
  EXPECT_EQ(tracer.trace_cache(frame.get(), cache).layers_found, 128u);
}

TEST(TracerFrame, surfaces_before_the_near_plane_are_not_met) {
  TestScene scene;
  add_panes(scene, 1, 0.05f, 1.0f, blended({1, 0, 0}, 0.5f));
  const uint32_t behind = scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, blended({1, 1, 1}, 0.5f));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  LayerCache cache;
  tracer.trace_cache(TestFrame(forward_view(), 8, 8, 1).get(), cache);
  EXPECT_THAT(cache.surface_id, testing::Each(behind));
}

TEST(TracerFrame, orthographic_distances_start_at_the_near_plane) {
  TestScene scene;
  add_panes(scene, 2, 3.0f, 1.0f, blended({1, 0, 0}, 0.5f));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  TraceView view;
  view.clip_from_local = glm::orthoRH_ZO(-2.0, 2.0, -2.0, 2.0, 100.0, 0.5);
  view.local_from_clip = glm::inverse(view.clip_from_local);
  view.reversed_depth = view.zero_to_one_depth = true;
  LayerCache cache;
  tracer.trace_cache(TestFrame(view, 16, 16, 2).get(), cache);
  for (size_t i = 0; i < 256; ++i) {
    EXPECT_NEAR(cache.distance[i], 2.5f, 1e-5f);
    EXPECT_NEAR(cache.distance[256 + i], 3.5f, 1e-5f);
  }
}

TEST(TracerFrame, a_cancelled_frame_ends_early_and_the_next_sends_everything) {
  TestScene scene;
  add_panes(scene, 1, 2.0f, 1.0f, blended({1, 0, 0}, 0.5f));
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  LayerCache cache;
  TestFrame frame(forward_view(), 128, 128, 1);
  tracer.trace_cache(frame.get(), cache);
  const std::atomic<bool> cancelled{true};
  frame.request.cancelled = &cancelled;
  EXPECT_EQ(tracer.trace_cache(frame.get(), cache).rays_primary, 0u);
  EXPECT_THAT(cache.distance, testing::Each(0.0f));
  TestFrame next(forward_view(), 128, 128, 1, 0);
  tracer.trace_cache(next.get(), cache);
  EXPECT_THAT(cache.dirty_tiles, testing::Each(1));
}

TEST(TracerFrame, refuses_what_makes_no_sense) {
  TestScene scene;
  Tracer tracer({.threads = 1, .isa = ""});
  LayerCache cache;
  EXPECT_THROW(tracer.trace_cache(TestFrame(forward_view(), 8, 8, 1).get(), cache), std::runtime_error);
  tracer.set_scene(scene.commit());
  EXPECT_THROW(tracer.trace_cache(TestFrame(forward_view(), 8, 8, 9).get(), cache), std::runtime_error);
  TestFrame frame(forward_view(), 8, 8, 1);
  frame.get().depth.format = DepthFormat::d32f;
  EXPECT_THROW(tracer.trace_cache(frame.request, cache), std::runtime_error);
  EXPECT_EQ(cache.width, 0u);
}

TEST(TracerFrame, an_empty_scene_gives_no_answers) {
  TestScene scene;
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  LayerCache cache;
  const Counters counters = tracer.trace_cache(TestFrame(forward_view(), 16, 16, 2).get(), cache);
  EXPECT_THAT(cache.distance, testing::Each(0.0f));
  EXPECT_EQ(counters.layers_found, 0u);
}

}  // namespace
}  // namespace sideray::rt::tracer_frame_test
