// Tests masks of still views: once converged they are neither traced nor changed, and any change traces them again.
#include "rt/masks/kept_masks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "model/failure.h"
#include "rt/base/view_rays.h"
#include "rt/masks/mask_filters.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

constexpr uint32_t kept_width = 96, kept_height = 64, settled = 47;
constexpr auto every_frame = SequenceStep::next;

// A floor under a plate, two lamps of some size, and what a test changes.
class StandsStill : public testing::Test {
 protected:
  StandsStill() {
    scene_.quad({0, 0, 0}, {20, 0, 0}, {0, 0, 20}, plain_material());
    scene_.quad({0, 1.5f, 0}, {1, 0, 0}, {0, 0, 1}, plain_material());
    commit();
    look({0, 3, 6});
  }

  void commit() {
    lamps_[0].radius = lamps_[1].radius = radius_;
    scene_.lights(lamps_);
    tracer_.set_scene(scene_.commit());
  }

  void look(glm::dvec3 eye, glm::dvec2 jitter = glm::dvec2(0.0)) {
    view_ = perspective(eye, {0, 0.5, 0}, 0.7, double{kept_width} / kept_height);
    const glm::dvec2 moved_by = jitter / glm::dvec2(kept_width, kept_height);
    const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), glm::dvec3(moved_by, 0));
    view_.clip_from_local = moved * view_.clip_from_local;
    view_.local_from_clip = glm::inverse(view_.clip_from_local);
    const ViewRays rays(view_, kept_width, kept_height);
    for (uint32_t y = 0; y < kept_height; ++y)
      for (uint32_t x = 0; x < kept_width; ++x) {
        const Ray ray = rays.ray(x, y);
        const glm::dvec3 from(ray.origin), d(ray.direction);
        const glm::dvec4 clip = view_.clip_from_local * glm::dvec4(from - d * (from.y / d.y), 1.0);
        depth_.set(x, y, static_cast<float>(clip.z / clip.w), 0);
      }
  }

  MaskRequest request(SequenceStep step) {
    MaskRequest r;
    r.view = view_;
    r.width = kept_width, r.height = kept_height;
    r.depth = depth_.image();
    r.shadow_lights = 3;
    r.least_light = least_light_;
    r.seed = ++seed_;
    r.filters = filtered_ ? &filters_ : nullptr;
    r.kept = &kept_;
    r.sequence = step;
    return r;
  }
  // Returns how many rays the frame has taken.
  uint64_t frame(const MaskRequest& r) {
    const Counters counters = tracer_.trace_masks(r, masks_);
    return counters.rays_shadow + counters.rays_ao;
  }
  uint64_t frame(SequenceStep step = every_frame) { return frame(request(step)); }
  void settle() {
    frame(SequenceStep::first);
    for (uint32_t i = 0; i < settled; ++i) ASSERT_GT(frame(), 0u) << i;
    ASSERT_EQ(frame(), 0u);
  }

  TestScene scene_;
  std::vector<sideray_light> lamps_{point_light({1, 6, 1}, 20.0f), point_light({-3, 5, 0}, 20.0f)};
  float radius_ = 0.5f;
  Tracer tracer_{{2, ""}};
  TraceView view_;
  DepthBuffer depth_{kept_width, kept_height, 0.0f, 0};
  MaskFilters filters_;
  KeptMasks kept_;
  OcclusionMasks masks_;
  bool filtered_ = true;
  uint32_t seed_ = 0;
  float least_light_ = 0.0f;
};

TEST(KeptMasks, settle_when_less_than_half_a_step_is_left_of_the_past) {
  for (const uint32_t history : {1u, 2u, 8u, 16u, 255u}) {
    const uint32_t frames = KeptMasks::frames_to_settle(history);
    const double left = 1.0 - 1.0 / history;
    EXPECT_LT(std::pow(left, frames) * 255.0, history == 1 ? 256.0 : 0.5) << history;
    EXPECT_TRUE(frames == 0 || std::pow(left, frames - 1) * 512.0 >= 1.0) << history;
  }
  EXPECT_EQ(KeptMasks::frames_to_settle(8), settled);
  EXPECT_EQ(KeptMasks::frames_to_settle(1), 0u);
}

TEST_F(StandsStill, no_ray_is_traced_once_the_mean_over_frames_has_settled) {
  settle();
  const std::vector<uint8_t> mask = masks_.lit;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(frame(), 0u);
  EXPECT_EQ(masks_.lit, mask);
  EXPECT_TRUE(kept_.keeps_all());
  EXPECT_GT(std::count_if(mask.begin(), mask.end(), [](uint8_t v) { return v > 0 && v < 255; }), 100);
}

// The reused mask is that of a sequence that traces every frame, at that moment.
TEST_F(StandsStill, the_mask_that_stays_is_the_one_that_tracing_every_frame_has_there) {
  settle();
  MaskFilters filters;
  OcclusionMasks masks;
  seed_ = 0;
  for (uint32_t i = 0; i <= settled; ++i) {
    MaskRequest r = request(i == 0 ? SequenceStep::first : SequenceStep::next);
    r.filters = &filters, r.kept = nullptr;
    tracer_.trace_masks(r, masks);
  }
  EXPECT_EQ(masks_.lit, masks.lit);
}

TEST_F(StandsStill, whatever_changes_what_masks_show_makes_them_traced_again) {
  const std::vector<std::pair<const char*, std::function<void(MaskRequest&)>>> changes{
      {"camera", [&](MaskRequest& r) { look({0.01, 3, 6}), r.view = view_; }},
      {"depth of one pixel", [&](MaskRequest&) { depth_.set(5, 5, 0.5f, 0); }},
      {"something opaque comes",
       [&](MaskRequest&) {
         scene_.quad({2, 1, 0}, {1, 0, 0}, {0, 0, 1}, plain_material());
         commit();
       }},
      {"lights that end nearer", [&](MaskRequest& r) { r.least_light = 0.02f; }},
      {"bias", [&](MaskRequest& r) { r.shadow_bias = 0.001f; }},
      {"ambient occlusion", [&](MaskRequest& r) { r.ao_rays = 4; }},
      {"light that is not asked for any longer", [&](MaskRequest& r) { r.shadow_lights = 1; }},
      {"no filter", [&](MaskRequest& r) { r.filters = nullptr; }},
      {"snapping of vertices", [&](MaskRequest& r) { r.subpixel *= 2.0f; }},
      {"distances of hits", [&](MaskRequest& r) { r.hit_distances = true; }},
      {"a cut", [&](MaskRequest& r) { r.sequence = SequenceStep::first; }}};
  for (const auto& [what, change] : changes) {
    settle();
    MaskRequest r = request(every_frame);
    change(r);
    EXPECT_GT(frame(r), 0u) << what;
    look({0, 3, 6});
  }
}

TEST_F(StandsStill, a_light_that_moves_takes_its_own_mask_along_and_no_other) {
  settle();
  const std::vector<uint8_t> before = masks_.lit;
  lamps_[1].position[0] += 0.5;
  commit();
  const uint64_t rays = frame();
  const auto half = static_cast<ptrdiff_t>(before.size() / 2);
  EXPECT_GT(rays, 0u);
  EXPECT_TRUE(kept_.keeps(0));
  EXPECT_FALSE(kept_.keeps(1));
  EXPECT_TRUE(std::equal(before.begin(), before.begin() + half, masks_.lit.begin()));
  EXPECT_FALSE(std::equal(before.begin() + half, before.end(), masks_.lit.begin() + half));
  for (uint32_t i = 1; i < settled; ++i) EXPECT_GT(frame(), 0u) << i;
  frame();
  EXPECT_EQ(frame(), 0u);
}

TEST_F(StandsStill, colours_of_lights_and_surfaces_are_no_change) {
  settle();
  lamps_[0].intensity[0] *= 2.0f;
  commit();
  EXPECT_EQ(frame(), 0u);
  sideray_material_desc red = plain_material();
  red.base_color[1] = 0.1f;
  scene_.scene.replace_material(1, red);
  commit();
  EXPECT_EQ(frame(), 0u);
}

TEST_F(StandsStill, glass_that_comes_makes_masks_of_lights_traced_again) {
  settle();
  scene_.quad({0, 2, 0}, {1, 0, 0}, {0, 0, 1}, glass());
  commit();
  EXPECT_GT(frame(), 0u) << "it throws a shadow";
  for (uint32_t i = 1; i < settled; ++i) frame();
  frame();
  EXPECT_EQ(frame(), 0u);
}

// A brighter light reaches farther, which matters where its range is limited.
TEST_F(StandsStill, the_brightness_of_a_light_is_a_change_where_it_ends_where_it_adds_little) {
  least_light_ = 0.01f;
  settle();
  lamps_[1].intensity[0] *= 2.0f;
  commit();
  EXPECT_GT(frame(), 0u);
  EXPECT_TRUE(kept_.keeps(0));
  EXPECT_FALSE(kept_.keeps(1));
}

TEST_F(StandsStill, an_instance_that_moves_is_a_change) {
  settle();
  const glm::dmat4x3 moved{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0, 0}};
  const uint32_t plate = 2;
  scene_.scene.move_instances(&plate, 1, &moved[0][0]);
  commit();
  EXPECT_GT(frame(), 0u);
}

TEST_F(StandsStill, motion_of_one_pixel_is_a_change) {
  std::vector<glm::vec2> motion(size_t{kept_width} * kept_height, glm::vec2(0.0f));
  settle();
  MaskRequest r = request(every_frame);
  r.motion = motion;
  EXPECT_EQ(frame(r), 0u);
  motion[777].x = 0.25f;
  r = request(every_frame);
  r.motion = motion;
  EXPECT_GT(frame(r), 0u);
}

TEST_F(StandsStill, masks_without_random_samples_are_traced_once) {
  radius_ = 0.0f;
  commit();
  EXPECT_GT(frame(SequenceStep::first), 0u);
  EXPECT_EQ(frame(), 0u);
  EXPECT_EQ(frame(SequenceStep::first), 0u);
}

TEST_F(StandsStill, samples_that_nothing_averages_are_kept_only_where_they_are_the_same) {
  filtered_ = false;
  EXPECT_GT(frame(SequenceStep::first), 0u);
  for (uint32_t i = 0; i < 2 * settled; ++i) ASSERT_GT(frame(), 0u) << i;
  --seed_;
  EXPECT_EQ(frame(), 0u);
}

TEST_F(StandsStill, a_frame_that_follows_none_is_kept_where_its_samples_are_the_same) {
  EXPECT_GT(frame(SequenceStep::first), 0u);
  --seed_;
  EXPECT_EQ(frame(SequenceStep::first), 0u);
  EXPECT_GT(frame(SequenceStep::first), 0u);
}

// A repeated frame traces as many rays as the picture, unless it is drawn as one after which nothing has changed.
TEST_F(StandsStill, a_frame_drawn_again_traces_what_it_traced) {
  frame(SequenceStep::first);
  const uint64_t rays = frame();
  const std::vector<uint8_t> mask = masks_.lit;
  const auto again = [&](bool keeps) {
    --seed_;
    MaskRequest r = request(SequenceStep::again);
    r.redraw_keeps = keeps;
    return frame(r);
  };
  EXPECT_EQ(again(false), rays);
  EXPECT_EQ(masks_.lit, mask);
  EXPECT_EQ(again(true), 0u);
  EXPECT_EQ(again(false), rays);
  EXPECT_EQ(masks_.lit, mask);
  settle();
  EXPECT_EQ(again(false), 0u);
}

TEST_F(StandsStill, what_was_given_up_or_given_back_is_traced_again) {
  settle();
  kept_.forget();
  EXPECT_GT(frame(), 0u);
  radius_ = 0.0f;
  commit();
  MaskRequest r = request(every_frame);
  r.work.deadline = Deadline::min();
  frame(r);
  EXPECT_GT(frame(), 0u) << "all that was late";
  EXPECT_EQ(frame(), 0u);
}

TEST_F(StandsStill, a_bad_request_is_refused_and_touches_nothing) {
  settle();
  MaskRequest bad = request(every_frame);
  bad.depth = {};
  EXPECT_THROW(frame(bad), Failure);
  bad = request(every_frame);
  bad.shadow_lights = 0x100;
  EXPECT_THROW(frame(bad), Failure);
  EXPECT_EQ(frame(), 0u) << "no mask was touched";
}

// A view with eight jitter positions in turn: each position has its mask from when all had converged.
TEST_F(StandsStill, places_in_the_pixel_have_masks_of_their_own) {
  std::vector<std::vector<uint8_t>> shown;
  const uint32_t first_kept = 8 + settled;
  for (uint32_t i = 0; i < first_kept + 16; ++i) {
    look({0, 3, 6}, {0.1 * (i % 8), 0.05 * (i % 4)});
    const uint64_t rays = frame(i == 0 ? SequenceStep::first : SequenceStep::next);
    EXPECT_EQ(rays == 0, i >= first_kept) << i;
    EXPECT_TRUE(i < first_kept || masks_.lit == shown[i - 8]) << i;
    shown.push_back(masks_.lit);
  }
  EXPECT_NE(shown[first_kept], shown[first_kept + 1]);
}

// After rest the history continues where it was left.
TEST_F(StandsStill, the_first_frame_in_motion_follows_the_mask_that_stood) {
  settle();
  for (int i = 0; i < 5; ++i) frame();
  look({0.02, 3, 6});
  frame();
  const std::vector<uint8_t> moved = masks_.lit;
  MaskFilters filters;
  OcclusionMasks masks;
  const uint32_t last = seed_;
  look({0, 3, 6});
  seed_ = 0;
  for (uint32_t i = 0; i <= settled; ++i) {
    MaskRequest r = request(i == 0 ? SequenceStep::first : SequenceStep::next);
    r.filters = &filters, r.kept = nullptr;
    tracer_.trace_masks(r, masks);
  }
  look({0.02, 3, 6});
  seed_ = last - 1;
  MaskRequest r = request(every_frame);
  r.filters = &filters, r.kept = nullptr;
  tracer_.trace_masks(r, masks);
  EXPECT_EQ(moved, masks.lit);
}

// Ambient occlusion depends on translucent surfaces, and so do masks of lights.
TEST_F(StandsStill, what_veils_the_sky_makes_its_mask_traced_again) {
  const auto ambient = [&](SequenceStep step) {
    MaskRequest r = request(step);
    r.filters = nullptr, r.ao_rays = 2, r.seed = 1;
    return frame(r);
  };
  scene_.quad({0, 1, 0}, {1, 0, 0}, {0, 0, 1}, blended(glm::vec3(1), 0.5f));
  commit();
  ambient(SequenceStep::first);
  ambient(every_frame);
  ASSERT_EQ(ambient(every_frame), 0u);
  commit();
  ASSERT_EQ(ambient(every_frame), 0u) << "a commit that changes nothing";
  scene_.quad({2, 1, 0}, {1, 0, 0}, {0, 0, 1}, blended(glm::vec3(1), 0.5f));
  commit();
  EXPECT_GT(ambient(every_frame), 0u);
  EXPECT_FALSE(kept_.keeps(0) || kept_.keeps(1) || kept_.keeps(2));
}

// Rays that sample the environment change with it.
TEST_F(StandsStill, other_surroundings_make_the_sky_traced_again_where_rays_go_by_their_light) {
  for (const bool by_light : {true, false}) {
    SCOPED_TRACE(by_light);
    const auto traced = [&] {
      MaskRequest r = request(every_frame);
      r.filters = nullptr, r.ao_rays = 2, r.seed = 1, r.shadow_lights = 0, r.ao_by_light = by_light;
      return frame(r);
    };
    scene_.environment({1, 1, 1});
    commit();
    traced();
    traced();
    EXPECT_EQ(traced(), 0u);
    commit();
    EXPECT_EQ(traced(), 0u) << "the surroundings are the same";
    scene_.environment({2, 1, 0});
    commit();
    EXPECT_EQ(traced() > 0, by_light);
  }
}

TEST_F(StandsStill, the_same_bits_and_rays_for_any_thread_count) {
  std::vector<uint8_t> expected;
  for (const uint32_t threads : {1u, 2u}) {
    Tracer tracer({threads, ""});
    tracer.set_scene(scene_.commit());
    MaskFilters filters;
    KeptMasks kept;
    OcclusionMasks masks;
    seed_ = 0;
    for (uint32_t i = 0; i < settled + 3; ++i) {
      MaskRequest r = request(i == 0 ? SequenceStep::first : SequenceStep::next);
      r.filters = &filters, r.kept = &kept;
      r.ao_rays = 2;
      const Counters counters = tracer.trace_masks(r, masks);
      EXPECT_EQ(counters.rays_shadow + counters.rays_ao == 0, i > settled) << i;
    }
    masks.lit.insert(masks.lit.end(), masks.open.begin(), masks.open.end());
    if (expected.empty()) expected = masks.lit;
    EXPECT_EQ(masks.lit, expected);
  }
}

}  // namespace
}  // namespace sideray::rt
