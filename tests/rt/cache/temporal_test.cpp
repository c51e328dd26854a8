// Temporal cache rates: what is shaded anew, what is taken over from the frame before, and what never is.
#include <gmock/gmock.h>

#include "rt/cache/temporal_history.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

constexpr double fov = 0.8;
constexpr uint32_t side = 64;  // of the picture: divisible by every period

TraceView view_from(glm::dvec3 eye) {
  return perspective(eye, eye + glm::dvec3(0, 0, -1), fov, 1.0);
}

// Frames of a sequence, traced in turn.
class Sequence {
 public:
  explicit Sequence(sideray_cache_rate rate, uint32_t threads = 2, uint32_t layers = 2)
      : tracer({.threads = threads, .isa = ""}), rate_(rate), layers_(layers) {}

  Counters frame(std::shared_ptr<const model::Snapshot> snapshot, const TraceView& view,
                      SequenceStep step = SequenceStep::next) {
    tracer.set_scene(std::move(snapshot));
    TestFrame traced(view, side, side, layers_);
    traced.request.cache_rate = rate_;
    traced.request.sequence = step;
    traced.request.history = &history;
    return tracer.trace_cache(traced.get(), cache);
  }

  Tracer tracer;
  LayerHistory history;
  LayerCache cache;

 private:
  sideray_cache_rate rate_;
  uint32_t layers_;
};

LayerCache at_full_rate(const std::shared_ptr<const model::Snapshot>& snapshot, const TraceView& view) {
  Sequence full(SIDERAY_RATE_FULL);
  full.frame(snapshot, view);
  return full.cache;
}

void expect_equal(const LayerCache& a, const LayerCache& b) {
  EXPECT_EQ(a.radiance, b.radiance);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.surface_id, b.surface_id);
}

sideray_material_desc rough_mirror() {
  sideray_material_desc m = mirror();
  m.roughness = 0.3f;
  return m;
}

// Two layers over the whole view, the nearer one rough; what they reflect varies.
void add_varied_panes(TestScene& scene) {
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, rough_mirror());
  scene.quad({0, 0, -3}, {50, 0, 0.5f}, {0, 50, 0}, mirror());
  for (int i = -6; i <= 6; ++i)
    scene.quad({static_cast<float>(i), 0, 4}, {0.2f, 0, 0}, {0, 20, 0},
               glowing({1.0f + static_cast<float>(i & 3), 2.0f, static_cast<float>(i & 1)}));
  scene.environment({0.2f, 0.3f, 0.4f});
}

struct RateCase {
  sideray_cache_rate rate;
  uint32_t period;
};
class Temporal : public testing::TestWithParam<RateCase> {};
INSTANTIATE_TEST_SUITE_P(rates, Temporal,
                         testing::Values(RateCase{SIDERAY_RATE_TEMPORAL4, 4}, RateCase{SIDERAY_RATE_TEMPORAL8, 8}),
                         [](const auto& rate) { return "temporal" + std::to_string(rate.param.period); });

TEST_P(Temporal, every_pixel_is_shaded_once_a_period_and_neighbours_never_together) {
  const uint32_t period = GetParam().period;
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t x = 0; x < 8; ++x) {
      uint32_t frames = 0;
      for (uint32_t frame = 16; frame < 16 + period; ++frame) {
        if (!is_shaded_anew(period, frame, x, y)) continue;
        ++frames;
        for (const glm::uvec2 next : {glm::uvec2(x + 1, y), glm::uvec2(x, y + 1), glm::uvec2(x + 1, y + 1)})
          EXPECT_FALSE(is_shaded_anew(period, frame, next.x, next.y));
      }
      EXPECT_EQ(frames, 1u);
    }
}

TEST_P(Temporal, the_first_frame_and_frames_without_a_history_are_full_rate) {
  TestScene scene;
  add_varied_panes(scene);
  const auto snapshot = scene.commit();
  const LayerCache full = at_full_rate(snapshot, view_from({0, 0, 0}));
  Sequence sequence(GetParam().rate);
  const Counters counters = sequence.frame(snapshot, view_from({0, 0, 0}));
  expect_equal(sequence.cache, full);
  EXPECT_EQ(counters.layers_shaded, counters.layers_found);
  // A cut: what the frame before knows does not count.
  sequence.frame(snapshot, view_from({0.5, 0, 0}));
  sequence.frame(snapshot, view_from({0, 0, 0}), SequenceStep::first);
  expect_equal(sequence.cache, full);
}

TEST_P(Temporal, each_frame_of_an_unmoved_view_shades_its_share) {
  TestScene scene;
  add_varied_panes(scene);
  const auto snapshot = scene.commit();
  Sequence sequence(GetParam().rate);
  sequence.frame(snapshot, view_from({0.1, 0.2, 0}), SequenceStep::first);
  for (uint32_t i = 0; i < 2 * GetParam().period; ++i) {
    const Counters counters = sequence.frame(snapshot, view_from({0.1, 0.2, 0}));
    EXPECT_EQ(counters.layers_found, 2u * side * side);
    EXPECT_EQ(counters.layers_shaded, 2u * side * side / GetParam().period);
    EXPECT_EQ(counters.rays_primary, uint64_t{side} * side);
  }
}

// Where the light differs from what it was, every pixel must have been shaded anew after one period at the latest: the
// history would show the old light for ever.
TEST_P(Temporal, every_pixel_of_a_still_view_is_shaded_within_a_period) {
  TestScene scene;
  const uint32_t mover = scene.quad({0, 0, 6}, {1, 0, 0}, {0, 20, 0}, glowing({5, 5, 5}));
  add_varied_panes(scene);
  Sequence sequence(GetParam().rate);
  sequence.frame(scene.commit(), view_from({0, 0, 0}), SequenceStep::first);
  // Only reflected: nothing that the history compares has changed.
  const double moved[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 3, 0, 0};
  scene.scene.move_instances(&mover, 1, moved);
  const auto snapshot = scene.commit();
  const LayerCache full = at_full_rate(snapshot, view_from({0, 0, 0}));
  for (uint32_t i = 0; i < GetParam().period; ++i) {
    EXPECT_NE(sequence.cache.radiance, full.radiance);
    sequence.frame(snapshot, view_from({0, 0, 0}));
  }
  expect_equal(sequence.cache, full);
}

// A pane whose own light varies from left to right, so that light names the place that it comes from.
struct RampPane {
  std::vector<glm::vec3> corners{{-1, -1, -3}, {1, -1, -3}, {1, 1, -3}, {-1, 1, -3}};
  TestScene scene;
  uint32_t pane = 0;

  RampPane() {
    sideray_material_desc material = glowing({0, 0, 0});
    material.alpha_mode = SIDERAY_BLEND;
    std::vector<uint8_t> ramp(size_t{256} * 4);
    for (size_t i = 0; i < 256; ++i)
      for (size_t c = 0; c < 4; ++c) ramp[4 * i + c] = c == 3 ? 255 : static_cast<uint8_t>(i);
    material.emissive_texture = no_texture();
    material.emissive_texture.texture = scene.scene.add_texture(256, 1, SIDERAY_RGBA8, ramp.data());
    material.emissive_texture.wrap_u = SIDERAY_CLAMP;
    material.emissive[0] = material.emissive[1] = material.emissive[2] = 1.0f;
    pane = scene.add(corners, {{0, 1}, {1, 1}, {1, 0}, {0, 0}}, {0, 1, 2, 0, 2, 3}, material, glm::dmat4(1.0));
  }

  void set_corners(glm::vec3 offset, const std::vector<glm::vec2>& uv) {
    std::vector<glm::vec3> moved = corners;
    for (glm::vec3& p : moved) p += offset;
    sideray_mesh_desc mesh{};
    mesh.size = sizeof(mesh);
    mesh.vertex_count = 4;
    mesh.positions = {&moved[0].x, 0};
    mesh.uv0 = {&uv[0].x, 0};
    scene.scene.set_vertices(1, mesh);
  }
};

constexpr double pane_pixel = 2 * 0.42279321873 * 3 / side;  // its width at the pane: tan(0.5 * fov)

// A share is shaded anew, and the rim that was uncovered; all others took their light along.
void expect_light_taken_along(const Counters& counters, const LayerCache& cache, const LayerCache& full) {
  EXPECT_LT(counters.layers_shaded, counters.layers_found / 5);
  EXPECT_EQ(cache.distance, full.distance);
  for (size_t t = 0; t < full.distance.size(); ++t) {
    if (full.distance[t] <= 0.0f) continue;
    // Bilinear means keep a ramp but for its codes and the roundings to half; at the rim, where neighbours lie on one
    // side only, they stand less than a pixel away.
    const float expected = rgb(full.radiance, t).x;
    const bool inside = expected > 0.2f && expected < 0.8f;
    const double bound = inside ? 1.0 / 255 + 7 * 0x1p-11 : 0.5 * pane_pixel;
    EXPECT_NEAR(rgb(cache.radiance, t).x, expected, bound) << t;
  }
}

// It moves under a still eye, by its place and by its vertices.
TEST(TemporalMotion, a_moving_pane_takes_its_light_along) {
  for (const bool by_vertices : {false, true}) {
    RampPane ramp;
    Sequence sequence(SIDERAY_RATE_TEMPORAL8);
    sequence.frame(ramp.scene.commit(), view_from({0, 0, 0}), SequenceStep::first);
    for (int i = 1; i <= 6; ++i) {
      const double x = 0.7 * pane_pixel * i, y = 0.3 * pane_pixel * i;
      const double moved[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, x, y, 0};
      if (by_vertices)
        ramp.set_corners(glm::vec3(x, y, 0), {{0, 1}, {1, 1}, {1, 0}, {0, 0}});
      else
        ramp.scene.scene.move_instances(&ramp.pane, 1, moved);
      const auto snapshot = ramp.scene.commit();
      const Counters counters = sequence.frame(snapshot, view_from({0, 0, 0}));
      expect_light_taken_along(counters, sequence.cache, at_full_rate(snapshot, view_from({0, 0, 0})));
    }
  }
}

// Rays hit poses, each in a mesh of its own from frame to frame.
TEST(TemporalMotion, a_pane_in_the_wind_takes_its_light_along) {
  RampPane ramp;
  const sideray_wind_desc breeze{.size = sizeof(sideray_wind_desc),
                                 .direction = {1, 0, 0},
                                 .amplitude = 0.2f,
                                 .frequency = 0.5f,
                                 .height = 1.0f,
                                 .branch_amplitude = 0,
                                 .branch_frequency = 1,
                                 .leaf_amplitude = 0,
                                 .leaf_frequency = 1,
                                 .wavelength = 1};
  ramp.scene.scene.add_wind(breeze);
  Sequence sequence(SIDERAY_RATE_TEMPORAL8), full(SIDERAY_RATE_FULL);
  for (Sequence* s : {&sequence, &full})
    s->tracer.set_foliage({.poses = SIDERAY_POSES_ALL});
  LayerCache before;
  for (int i = 0; i <= 6; ++i) {
    ramp.scene.scene.set_time(0.02 * i, 0.02 * i);
    auto snapshot = std::make_shared<model::Snapshot>(*ramp.scene.commit());
    snapshot->instances[ramp.pane - 1].wind = 1;
    const Counters counters =
        sequence.frame(snapshot, view_from({0, 0, 0}), i == 0 ? SequenceStep::first : SequenceStep::next);
    full.frame(snapshot, view_from({0, 0, 0}));
    if (i > 0) {
      EXPECT_NE(before.distance, full.cache.distance) << "or it stands still";
      expect_light_taken_along(counters, sequence.cache, full.cache);
    }
    before = full.cache;
  }
}

// Left and right of an edge lie surfaces of their own light, which never mix though they are coplanar.
TEST(TemporalMotion, light_stays_on_its_surface) {
  TestScene scene;
  const auto pane = [](glm::vec3 light) {
    sideray_material_desc m = glowing(light);
    m.alpha_mode = SIDERAY_BLEND;
    return m;
  };
  const uint32_t red = scene.quad({-5, 0, -3}, {5, 0, 0}, {0, 5, 0}, pane({1, 0, 0}));
  scene.quad({5, 0, -3}, {5, 0, 0}, {0, 5, 0}, pane({0, 1, 0}));
  const auto snapshot = scene.commit();
  Sequence sequence(SIDERAY_RATE_TEMPORAL8);
  for (int i = 0; i < 12; ++i) {
    sequence.frame(snapshot, view_from({0.013 * i, 0.007 * i, -0.02 * i}),
                   i == 0 ? SequenceStep::first : SequenceStep::next);
    for (size_t t = 0; t < size_t{side} * side; ++t) {
      const glm::vec3 expected = sequence.cache.surface_id[t] == red ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
      ASSERT_EQ(rgb(sequence.cache.radiance, t), expected) << i << ' ' << t;
    }
  }
}

// The walls of one solid have one id; their light must not mix, for it comes from other sides.
TEST(TemporalMotion, layers_of_one_surface_id_stay_apart) {
  TestScene scene;
  sideray_material_desc material = glowing({0, 0, 0});
  material.alpha_mode = SIDERAY_BLEND;
  const uint8_t black_and_white[8] = {0, 0, 0, 255, 255, 255, 255, 255};
  material.emissive_texture = no_texture();
  material.emissive_texture.texture = scene.scene.add_texture(2, 1, SIDERAY_RGBA8, black_and_white);
  material.emissive_texture.filter = SIDERAY_NEAREST;
  material.emissive[0] = material.emissive[1] = material.emissive[2] = 1.0f;
  // Two walls 2 cm apart: the nearer one black, the farther one white.
  std::vector<glm::vec3> corners;
  for (const float z : {-3.0f, -3.02f})
    for (const glm::vec2 xy : {glm::vec2(-9, -9), glm::vec2(9, -9), glm::vec2(9, 9), glm::vec2(-9, 9)})
      corners.push_back({xy.x, xy.y, z});
  const std::vector<glm::vec2> uv{{0.2f, 0}, {0.2f, 0}, {0.2f, 1}, {0.2f, 1},
                                  {0.8f, 0}, {0.8f, 0}, {0.8f, 1}, {0.8f, 1}};
  scene.add(corners, uv, {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7}, material, glm::dmat4(1.0));
  const auto snapshot = scene.commit();
  Sequence sequence(SIDERAY_RATE_TEMPORAL4);
  for (int i = 0; i < 8; ++i) {
    const Counters counters = sequence.frame(snapshot, view_from({0.02 * i, 0, -0.03 * i}),
                                                  i == 0 ? SequenceStep::first : SequenceStep::next);
    if (i > 0) {
      EXPECT_LT(counters.layers_shaded, counters.layers_found * 3 / 10);
    }
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x)
        for (uint32_t k = 0; k < 2; ++k)
          ASSERT_EQ(rgb(sequence.cache.radiance, texel_of(sequence.cache, x, y, k)).x, k == 0 ? 0.0f : 1.0f);
  }
}

TEST(TemporalMotion, what_was_hidden_is_shaded_at_once) {
  TestScene scene;
  // One layer a pixel: the near pane hides the far one, then steps aside.
  sideray_material_desc near = glowing({4, 0, 0}), far = glowing({0, 0, 2});
  near.alpha_mode = far.alpha_mode = SIDERAY_BLEND;
  const uint32_t mover = scene.quad({0, 0, -2}, {0.3f, 0, 0}, {0, 9, 0}, near);
  scene.quad({0, 0, -4}, {9, 0, 0}, {0, 9, 0}, far);
  Sequence sequence(SIDERAY_RATE_TEMPORAL8, 2, 1);
  sequence.frame(scene.commit(), view_from({0, 0, 0}), SequenceStep::first);
  const auto covered = [&](const LayerCache& cache) {
    return static_cast<uint64_t>(std::count(cache.surface_id.begin(), cache.surface_id.end(), mover));
  };
  const uint64_t hidden = covered(sequence.cache);
  ASSERT_GT(hidden, 500u);
  const double moved[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 50, 0, 0};
  scene.scene.move_instances(&mover, 1, moved);
  const Counters counters = sequence.frame(scene.commit(), view_from({0, 0, 0}));
  // Its share of the others, and all that was hidden.
  EXPECT_EQ(counters.layers_shaded, hidden + (counters.layers_found - hidden) / 8);
  for (size_t t = 0; t < size_t{side} * side; ++t) ASSERT_EQ(rgb(sequence.cache.radiance, t), glm::vec3(0, 0, 2));
}

TEST(TemporalMotion, what_was_outside_the_view_is_shaded_at_once) {
  TestScene scene;
  add_varied_panes(scene);
  const auto snapshot = scene.commit();
  Sequence sequence(SIDERAY_RATE_TEMPORAL4);
  sequence.frame(snapshot, view_from({0, 0, 0}), SequenceStep::first);
  const glm::dvec3 eye(0, 0, 0);
  const TraceView behind = perspective(eye, eye + glm::dvec3(1.8, 0, -1), fov, 1.0);
  const Counters counters = sequence.frame(snapshot, behind);
  EXPECT_EQ(counters.layers_shaded, counters.layers_found);
  expect_equal(sequence.cache, at_full_rate(snapshot, behind));
}

// Everything but places drops what is known.
TEST(TemporalChange, changed_light_and_changed_requests_start_anew) {
  TestScene scene;
  add_varied_panes(scene);
  scene.lights({point_light({0, 1, 1}, 4.0f)});
  Sequence sequence(SIDERAY_RATE_TEMPORAL4);
  const TraceView view = view_from({0, 0, 0});
  sequence.frame(scene.commit(), view, SequenceStep::first);
  const auto expect_all_shaded = [&](const char* what) {
    const Counters counters = sequence.frame(scene.commit(), view);
    EXPECT_EQ(counters.layers_shaded, counters.layers_found) << what;
    const Counters next = sequence.frame(scene.commit(), view);
    EXPECT_EQ(next.layers_shaded * 4, next.layers_found) << "after " << what;
  };
  scene.lights({point_light({0, 1, 1}, 5.0f)});
  expect_all_shaded("a light");
  scene.environment({0.2f, 0.3f, 0.5f});
  expect_all_shaded("the environment");
  std::vector<glm::vec3> corners{{-9, -9, -2}, {9, -9, -2}, {9, 9, -2}, {-9, 9, -2}};
  std::vector<glm::vec2> uv(4, glm::vec2(0.5f));
  sideray_mesh_desc other_uv{};
  other_uv.size = sizeof(other_uv);
  other_uv.vertex_count = 4;
  other_uv.positions = {&corners[0].x, 0};
  other_uv.uv0 = {&uv[0].x, 0};
  scene.scene.set_vertices(1, other_uv);
  expect_all_shaded("where a mesh reads its textures");
  scene.scene.set_visibility(3, SIDERAY_VISIBLE_ALL & ~uint32_t{SIDERAY_VISIBLE_REFLECTION});
  expect_all_shaded("a visibility");
  scene.quad({0, 3, 4}, {9, 0, 0}, {0, 0.1f, 0}, glowing({3, 3, 3}));
  expect_all_shaded("a new object");

  TestFrame frame(view, side, side, 2);
  frame.request.cache_rate = SIDERAY_RATE_TEMPORAL4;
  frame.request.sequence = SequenceStep::next;
  frame.request.history = &sequence.history;
  frame.request.shadows = false;
  const Counters counters = sequence.tracer.trace_cache(frame.get(), sequence.cache);
  EXPECT_EQ(counters.layers_shaded, counters.layers_found);
}

TEST(TemporalChange, a_frame_drawn_again_is_the_same_and_advances_nothing) {
  TestScene scene;
  add_varied_panes(scene);
  const auto snapshot = scene.commit();
  Sequence once(SIDERAY_RATE_TEMPORAL4), twice(SIDERAY_RATE_TEMPORAL4);
  for (int i = 0; i < 6; ++i) {
    const TraceView view = view_from({0.02 * i, 0, 0});
    const SequenceStep step = i == 0 ? SequenceStep::first : SequenceStep::next;
    const Counters counters = once.frame(snapshot, view, step);
    twice.frame(snapshot, view, step);
    const Counters again = twice.frame(snapshot, view, SequenceStep::again);
    expect_equal(once.cache, twice.cache);
    EXPECT_EQ(counters.layers_shaded, again.layers_shaded);
  }
}

TEST(TemporalChange, the_same_bits_for_any_number_of_threads) {
  TestScene scene;
  add_varied_panes(scene);
  const auto snapshot = scene.commit();
  Sequence one(SIDERAY_RATE_TEMPORAL4, 1), three(SIDERAY_RATE_TEMPORAL4, 3);
  for (int i = 0; i < 6; ++i)
    for (Sequence* sequence : {&one, &three})
      sequence->frame(snapshot, view_from({0.02 * i, 0.01 * i, -0.03 * i}),
                      i == 0 ? SequenceStep::first : SequenceStep::next);
  expect_equal(one.cache, three.cache);
}

TEST(TemporalChange, nothing_follows_a_cancelled_frame) {
  TestScene scene;
  add_varied_panes(scene);
  const auto snapshot = scene.commit();
  Sequence sequence(SIDERAY_RATE_TEMPORAL4);
  const TraceView view = view_from({0, 0, 0});
  sequence.frame(snapshot, view, SequenceStep::first);
  const std::atomic<bool> cancelled{true};
  TestFrame frame(view, side, side, 2);
  frame.request.cache_rate = SIDERAY_RATE_TEMPORAL4;
  frame.request.sequence = SequenceStep::next;
  frame.request.history = &sequence.history;
  frame.request.cancelled = &cancelled;
  sequence.tracer.trace_cache(frame.get(), sequence.cache);
  const Counters counters = sequence.frame(snapshot, view);
  EXPECT_EQ(counters.layers_shaded, counters.layers_found);
}

}  // namespace
}  // namespace sideray::rt
