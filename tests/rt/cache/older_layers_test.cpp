// Tests older answers under a deadline: the order of turns, the answers meanwhile, and what clears them. Work is
// bounded by pieces instead of a clock, and compared with a trace of the whole frame.
#include "rt/cache/older_layers.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "rt/base/deadline.h"
#include "rt/base/view_rays.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::older_layers_test {
namespace {

using namespace test;

constexpr uint32_t side = 96, layers = 2;
constexpr size_t plane = size_t{side} * side;
constexpr int64_t chunks = side * side / pixels_in_late_chunk, all = 1 << 20;
constexpr uint32_t none = 0;

TraceView from(glm::dvec3 eye) {
  return perspective(eye, eye + glm::dvec3(0, 0, -1), 0.8, 1.0);
}

sideray_material_desc glowing_pane(glm::vec3 light) {
  sideray_material_desc m = glowing(light);
  m.alpha_mode = SIDERAY_BLEND;
  m.base_color[3] = 0.5f;
  return m;
}

// A red pane before a green one, either over the whole view, and a blue plate between that may move. What moves behind the eye
// is seen in none of them.
struct Panes : TestScene {
  uint32_t red, green, blue, unseen;
  Panes() {
    red = quad({0, 0, -3}, {50, 0, 0}, {0, 50, 0}, glowing_pane({1, 0, 0}));
    green = quad({0, 0, -6}, {50, 0, -9}, {0, 50, 0}, glowing_pane({0, 1, 0}));
    blue = quad({0, 0, -2}, {0.3f, 0, 0}, {0, 0.3f, 0}, glowing_pane({0, 0, 1}));
    unseen = quad({0, 0, 9}, {1, 0, 0}, {0, 1, 0}, plain_material());
    lights({point_light({0, 0, 5}, 3.0f)});
  }
  void move(uint32_t name, glm::dvec3 by) {
    const double to[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, by.x, by.y, by.z};
    scene.move_instances(&name, 1, to);
  }
};

class Frames {
 public:
  explicit Frames(uint32_t threads = 2) : tracer_({.threads = threads, .isa = ""}) {}
  Counters frame(std::shared_ptr<const model::Snapshot> snapshot, const TraceView& view, int64_t pieces,
                 SequenceStep step = SequenceStep::next) {
    tracer_.set_scene(std::move(snapshot));
    TestFrame traced(view, side, side, layers, count);
    PiecesLeft left(pieces);
    traced.request.work.pieces = &left;
    traced.request.older = &older_;
    traced.request.sequence = step;
    traced.request.whole_pixels = whole;
    if (changed) changed(traced.request);
    if (masked) masked(traced.depth);
    return tracer_.trace_cache(traced.get(), cache);
  }
  LayerCache cache;
  uint32_t count = 63;
  bool whole = false;
  std::function<void(CacheRequest&)> changed;
  std::function<void(DepthBuffer&)> masked;

 private:
  Tracer tracer_;
  OlderLayers older_;
};

LayerCache whole_frame(const std::shared_ptr<const model::Snapshot>& snapshot, const TraceView& view) {
  Frames frames;
  frames.frame(snapshot, view, all, SequenceStep::first);
  return frames.cache;
}

void expect_same(const LayerCache& a, const LayerCache& b) {
  EXPECT_EQ(a.radiance, b.radiance);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.surface_id, b.surface_id);
}

// Counts the answers of a frame, all of whose layers are those of the surfaces that they name.
struct Answers {
  size_t pixels = 0, of_blue = 0, wrong_light = 0, wrong_place = 0;
};
Answers answers_of(const LayerCache& cache, const TraceView& view, glm::dvec2 blue_at, double off) {
  const ViewRays rays(view, side, side);
  Answers found;
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x)
      for (uint32_t k = 0; k < layers; ++k) {
        const size_t t = texel_of(cache, x, y, k);
        if (cache.distance[t] == 0.0f) break;
        found.pixels += k == 0;
        const glm::vec3 light = rgb(cache.radiance, t);
        const uint32_t id = cache.surface_id[t];
        const int brightest = light.x > light.y && light.x > light.z ? 1 : light.y > light.z ? 2 : 3;
        found.wrong_light += static_cast<uint32_t>(brightest) != id;
        found.of_blue += id == 3;
        const Ray ray = rays.ray(x, y);
        const glm::dvec3 p = glm::dvec3(ray.origin) + glm::dvec3(ray.direction) * double{cache.distance[t]};
        const double plane_off = id == 1 ? p.z + 3 : id == 2 ? p.z + 6 + 9.0 / 50 * p.x : p.z + 2;
        const bool beside = id == 3 && (std::abs(p.x - blue_at.x) > 0.3 + off || std::abs(p.y - blue_at.y) > 0.3 + off);
        found.wrong_place += std::abs(plane_off) > 1e-5 * double{cache.distance[t]} || beside;
      }
  return found;
}

TEST(OlderLayers, every_chunk_has_its_turn) {
  Panes panes;
  const auto snapshot = panes.commit();
  Frames frames;
  constexpr int64_t pieces = 10;
  for (int64_t f = 1; f <= chunks / pieces + 1; ++f) {
    const Counters c = frames.frame(snapshot, from({}), pieces, f == 1 ? SequenceStep::first : SequenceStep::next);
    const auto done = static_cast<uint64_t>(std::min(f * pieces, chunks)) * pixels_in_late_chunk;
    ASSERT_EQ(c.pixels_late, plane - done) << f;
    ASSERT_EQ(c.pixels_older, static_cast<uint64_t>(std::min((f - 1) * pieces, chunks - pieces)) * pixels_in_late_chunk) << f;
  }
  // Something moves in every frame: no answer is older than a turn.
  for (int f = 0; f < 20; ++f) {
    panes.move(panes.unseen, {0, 0, f});
    ASSERT_LT(frames.frame(panes.commit(), from({}), pieces).answer_age, uint64_t{chunks / pieces + 1}) << f;
  }
}

// Of a view without jitter whose rays have the same random numbers in every frame. Pictures of a sequence have neither: see
// StillView of test_cli.
TEST(OlderLayers, of_the_same_rays_have_the_same_bits) {
  Panes panes;
  const auto snapshot = panes.commit();
  const LayerCache whole = whole_frame(snapshot, from({}));
  for (const uint32_t threads : {1u, 3u}) {
    Frames frames(threads);
    frames.frame(snapshot, from({}), 7, SequenceStep::first);
    for (int64_t traced = 7; traced < chunks; traced += 7) frames.frame(snapshot, from({}), 7);
    expect_same(frames.cache, whole);
    frames.frame(snapshot, from({}), 0);
    expect_same(frames.cache, whole);
    EXPECT_THAT(frames.cache.dirty_tiles, testing::Each(0));
  }
}

// Fit near and far planes change the matrices, and nothing of what is seen.
TEST(OlderLayers, another_near_plane_is_the_same_view) {
  Panes panes;
  const auto snapshot = panes.commit();
  Frames frames;
  frames.frame(snapshot, from({}), all, SequenceStep::first);
  const LayerCache whole = frames.cache;
  EXPECT_EQ(frames.frame(snapshot, perspective({}, {0, 0, -1}, 0.8, 1.0, 0.25), 0).pixels_older, plane);
  expect_same(frames.cache, whole);
}

TEST(OlderLayers, a_moved_eye_finds_each_surface_where_it_is) {
  Panes panes;
  const auto snapshot = panes.commit();
  for (const glm::dvec3 step : {glm::dvec3(0.004, 0.002, 0), glm::dvec3(0.05, -0.03, 0.02), glm::dvec3(0, 0, -0.15)}) {
    Frames frames;
    frames.frame(snapshot, from({}), all, SequenceStep::first);
    for (int f = 1; f <= 5; ++f) {
      const TraceView view = from(double(f) * step);
      const Counters c = frames.frame(snapshot, view, none);
      const Answers found = answers_of(frames.cache, view, {}, 0.03);
      EXPECT_EQ(found.wrong_light, 0u);
      EXPECT_EQ(found.wrong_place, 0u) << f;
      EXPECT_EQ(c.pixels_older, found.pixels);
      EXPECT_EQ(c.answer_age, static_cast<uint64_t>(f));
      EXPECT_GT(found.pixels, plane * 17 / 20) << f;
    }
  }
}

// Layers that are moved again and again do not stay where their pixels are.
TEST(OlderLayers, slow_motion_is_followed) {
  Panes panes;
  const auto snapshot = panes.commit();
  Frames frames;
  frames.frame(snapshot, from({}), all, SequenceStep::first);
  TraceView view;
  for (int f = 1; f <= 40; ++f) frames.frame(snapshot, view = from({0.005 * f, 0, 0}), none);
  const LayerCache whole = whole_frame(snapshot, view);
  const size_t seen = answers_of(whole, view, {}, 0.01).of_blue;
  const Answers found = answers_of(frames.cache, view, {}, 0.03);
  EXPECT_EQ(found.wrong_place, 0u);
  EXPECT_NEAR(static_cast<double>(found.of_blue), static_cast<double>(seen), 0.1 * static_cast<double>(seen));
}

TEST(OlderLayers, a_moved_object_never_shows_another_surface) {
  Panes panes;
  Frames frames;
  frames.frame(panes.commit(), from({}), all, SequenceStep::first);
  const size_t blue = answers_of(frames.cache, from({}), {}, 0.01).of_blue;
  for (int f = 1; f <= 8; ++f) {
    const glm::dvec2 to(0.05 * f, -0.031 * f);
    panes.move(panes.blue, {to, 0});
    frames.frame(panes.commit(), from({}), f % 2 == 0 ? 3 : none);
    const Answers found = answers_of(frames.cache, from({}), to, 0.03);
    EXPECT_EQ(found.wrong_light, 0u);
    EXPECT_EQ(found.wrong_place, 0u);
    EXPECT_NEAR(static_cast<double>(found.of_blue), static_cast<double>(blue), 0.15 * static_cast<double>(blue)) << f;
    EXPECT_GT(found.pixels, plane * 9 / 10);
  }
}

TEST(OlderLayers, what_does_not_move_is_neither_moved_nor_sent) {
  Panes panes;
  Frames frames;
  panes.move(panes.blue, {0.4, 0.4, 0});
  frames.frame(panes.commit(), from({}), all, SequenceStep::first);
  panes.move(panes.blue, {0.45, 0.4, 0});
  frames.frame(panes.commit(), from({}), none);
  const LayerCache& c = frames.cache;
  EXPECT_THAT(c.dirty_tiles, testing::Contains(0));
  EXPECT_THAT(c.dirty_tiles, testing::Contains(1));
  size_t moved = 0;
  for (size_t t = 0; t < c.distance.size(); ++t) {
    if (c.distance[t] == 0.0f) continue;
    const bool is_moved = c.radiance[4 * t + 3] != 0x3c00;
    EXPECT_EQ(is_moved, c.surface_id[t] == 3);
    moved += is_moved;
  }
  EXPECT_GT(moved, 0u);
}

TEST(OlderLayers, lamps_materials_skies_cuts_and_options_leave_nothing) {
  const auto lamp = [](Panes& panes, Frames&) { panes.lights({point_light({0, 0, 5}, 4.0f)}); };
  const auto material = [](Panes& panes, Frames&) {
    panes.quad({0, 9, 0}, {1, 0, 0}, {0, 1, 0}, plain_material());
  };
  const auto environment = [](Panes& panes, Frames&) { panes.environment({1, 0, 0}); };
  const auto option = [](Panes&, Frames& frames) { frames.changed = [](CacheRequest& r) { r.shadows = false; }; };
  const std::function<void(Panes&, Frames&)> changes[] = {lamp, material, environment, option};
  for (const auto& change : changes) {
    Panes panes;
    Frames frames;
    frames.frame(panes.commit(), from({}), all, SequenceStep::first);
    ASSERT_EQ(frames.frame(panes.commit(), from({}), none).pixels_older, plane);
    change(panes, frames);
    const Counters c = frames.frame(panes.commit(), from({}), none);
    EXPECT_EQ(c.pixels_older, 0u);
    EXPECT_EQ(c.pixels_late, plane);
    EXPECT_THAT(frames.cache.distance, testing::Each(0.0f));
  }
  Panes panes;
  const auto snapshot = panes.commit();
  Frames frames;
  frames.frame(snapshot, from({}), all, SequenceStep::first);
  EXPECT_EQ(frames.frame(snapshot, from({}), none, SequenceStep::first).pixels_late, plane);
  EXPECT_THAT(frames.cache.distance, testing::Each(0.0f));
}

TEST(OlderLayers, nothing_is_older_than_the_bound) {
  Panes panes;
  Frames frames;
  frames.frame(panes.commit(), from({}), all, SequenceStep::first);
  for (uint32_t f = 1; f <= OlderLayers::oldest + 1; ++f) {
    panes.move(panes.unseen, {0, 0, f});
    const Counters c = frames.frame(panes.commit(), from({}), none);
    ASSERT_EQ(c.pixels_older, f <= OlderLayers::oldest ? plane : 0u) << f;
    ASSERT_EQ(c.answer_age, f <= OlderLayers::oldest ? f : 0u) << f;
  }
  EXPECT_THAT(frames.cache.distance, testing::Each(0.0f));
}

TEST(OlderLayers, a_pixel_stays_whole_where_as_many_are_drawn) {
  Panes panes;
  panes.scene.remove_instances(&panes.blue, 1);
  const auto snapshot = panes.commit();
  Frames frames;
  frames.whole = true;
  frames.count = 2;
  frames.frame(snapshot, from({}), all, SequenceStep::first);
  const auto whole = [&](uint32_t x, uint32_t y) { return frames.cache.whole_transmittance[4 * (y * side + x) + 3] != 0; };
  ASSERT_TRUE(whole(10, 30) && whole(40, 20) && whole(70, 30));
  // Something opaque stands before one pixel, more glass is drawn in another.
  frames.masked = [](DepthBuffer& depth) { depth.set(10, 30, 0.5f, 0), depth.set(40, 20, 0.0f, 3); };
  frames.frame(snapshot, from({}), none);
  EXPECT_FALSE(whole(10, 30));
  EXPECT_FALSE(whole(40, 20));
  EXPECT_TRUE(whole(70, 30));
  frames.frame(snapshot, from({0.01, 0, 0}), none);
  EXPECT_FALSE(whole(70, 30));
}

}  // namespace
}  // namespace sideray::rt::older_layers_test
