// Tests which work a deadline skips, and the order of work before it.
#include "rt/base/deadline.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>

#include "rt/masks/occlusion_masks.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;
using Clock = Deadline::clock;

TEST(DeadlineOrder, goes_outward_from_the_middle) {
  const std::vector<uint32_t> order = order_of_importance(5, 3);
  ASSERT_EQ(order.size(), 15u);
  EXPECT_EQ(order.front(), 7u);
  EXPECT_THAT((std::vector<uint32_t>{order.end() - 4, order.end()}), testing::UnorderedElementsAre(0u, 4u, 10u, 14u));
}

TEST(DeadlineOrder, takes_pixels_of_many_surfaces_earlier) {
  std::vector<PixelRequest> pixels;
  const auto add = [&](uint16_t x, uint32_t layers) { pixels.push_back({x, 50, layers, x, 50}); };
  add(20, 1), add(50, 1), add(80, 8), add(90, unlimited_layers);
  const std::vector<uint32_t> starts{0, 1, 2, 3, 4};
  EXPECT_THAT(order_of_importance(pixels, starts, 100, 100), testing::ElementsAre(2u, 1u, 3u, 0u));
}

class DeadlineFrame : public testing::Test {
 protected:
  DeadlineFrame() {
    for (int k = 0; k < 3; ++k)
      scene_.quad({0, 0, -2.0f - static_cast<float>(k)}, {50, 0, 0}, {0, 50, 0}, blended({1, 0, 0}, 0.5f));
    tracer_.set_scene(scene_.commit());
    tracer_.trace_cache(frame_.get(), whole_);
  }
  CacheRequest until(Deadline deadline) {
    CacheRequest request = frame_.get();
    request.work.deadline = deadline;
    return request;
  }

  TestScene scene_;
  Tracer tracer_{{.threads = 2, .isa = ""}};
  TestFrame frame_{perspective({0, 0, 0}, {0, 0, -1}, 0.8, 1.0), 96, 96, 3};
  LayerCache whole_;
};

TEST_F(DeadlineFrame, changes_nothing_while_it_is_far) {
  LayerCache cache;
  const Counters counters = tracer_.trace_cache(until(Clock::now() + std::chrono::hours(1)), cache);
  EXPECT_EQ(counters.pixels_late, 0u);
  EXPECT_EQ(cache.radiance, whole_.radiance);
  EXPECT_EQ(cache.distance, whole_.distance);
  EXPECT_EQ(cache.surface_id, whole_.surface_id);
}

TEST_F(DeadlineFrame, leaves_no_answer_where_it_has_passed) {
  LayerCache cache = whole_;  // answers of the frame before must go
  const Counters counters = tracer_.trace_cache(until(Clock::now() - std::chrono::seconds(1)), cache);
  EXPECT_EQ(counters.pixels_late, 96u * 96u);
  EXPECT_EQ(counters.pixels_masked, 96u * 96u);
  EXPECT_EQ(counters.rays_primary, 0u);
  EXPECT_THAT(cache.distance, testing::Each(0.0f));
  EXPECT_THAT(cache.dirty_tiles, testing::Each(1));
}

// However much of it is traced in time, that is right and the rest is empty.
TEST_F(DeadlineFrame, has_whole_answers_or_none) {
  for (int us = 1; us < 100'000; us *= 2) {
    LayerCache cache = whole_;
    const Counters counters = tracer_.trace_cache(until(Clock::now() + std::chrono::microseconds(us)), cache);
    const size_t plane = 96 * 96;
    uint64_t late = 0;
    for (size_t i = 0; i < plane; ++i) {
      const bool empty = cache.distance[i] == 0.0f;
      late += empty;
      for (size_t k = 0; k < 3; ++k)
        ASSERT_EQ(cache.distance[k * plane + i], empty ? 0.0f : whole_.distance[k * plane + i]) << us << ' ' << i;
    }
    EXPECT_EQ(late, counters.pixels_late) << us;
  }
}

TEST_F(DeadlineFrame, late_masks_are_lit) {
  sideray_light sun{};
  sun.size = sizeof(sun);
  sun.direction[2] = -1.0f;
  for (float& c : sun.intensity) c = 1.0f;
  TestScene scene;
  scene.quad({0, 0, -5}, {50, 0, 0}, {0, 50, 0}, plain_material());
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, plain_material());
  scene.lights({sun});
  tracer_.set_scene(scene.commit());
  TestFrame frame(perspective({0, 0, -3}, {0, 0, -5}, 0.8, 1.0), 64, 64, 1);
  for (uint32_t y = 0; y < 64; ++y)
    for (uint32_t x = 0; x < 64; ++x) frame.depth.set(x, y, 0.05f, 0);  // z = -5, in the other's shadow
  MaskRequest request;
  request.view = frame.get().view, request.depth = frame.get().depth;
  request.width = request.height = 64;
  request.shadow_lights = 1;
  OcclusionMasks masks;
  tracer_.trace_masks(request, masks);
  EXPECT_THAT(masks.lit, testing::Each(0));
  request.work.deadline = Clock::now() - std::chrono::seconds(1);
  EXPECT_EQ(tracer_.trace_masks(request, masks).rays_shadow, 0u);
  EXPECT_THAT(masks.lit, testing::Each(255));
}

}  // namespace
}  // namespace sideray::rt
