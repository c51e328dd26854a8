// Shading taken over from the frame before: what is, what never is, and for how long anything may be old. Full shading of
// each frame is the oracle.
#include <gmock/gmock.h>

#include "rt/cache/temporal_history.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::shading_reuse_test {
namespace {

using namespace test;

constexpr uint32_t side = 48, layers = 2;
constexpr uint64_t all_layers = uint64_t{layers} * side * side;
constexpr float bound = 0x1p-6f;
constexpr uint32_t period = 8;

TraceView from(glm::dvec3 eye) {
  return perspective(eye, eye + glm::dvec3(0, 0, -1), 0.8, 1.0);
}

class Reusing {
 public:
  explicit Reusing(float reuse = bound, uint32_t threads = 2) : tracer_({.threads = threads, .isa = ""}), reuse_(reuse) {}

  Counters frame(std::shared_ptr<const model::Snapshot> snapshot, const TraceView& view,
                 SequenceStep step = SequenceStep::next, float depth = 0.0f, uint32_t stencil = layers) {
    tracer_.set_scene(std::move(snapshot));
    TestFrame traced(view, side, side, layers, stencil);
    traced.depth = DepthBuffer(side, side, depth, stencil);
    traced.request.shading_reuse = reuse_;
    traced.request.sequence = step;
    traced.request.history = &history_;
    traced.request.whole_pixels = true;
    traced.request.refraction = true;
    traced.request.denoise = true;
    return tracer_.trace_cache(traced.get(), cache);
  }

  LayerCache cache;

 private:
  Tracer tracer_;
  LayerHistory history_;
  float reuse_;
};

LayerCache shaded(const std::shared_ptr<const model::Snapshot>& snapshot, const TraceView& view, float depth = 0.0f,
                  uint32_t stencil = layers) {
  Reusing full(0.0f);
  full.frame(snapshot, view, SequenceStep::first, depth, stencil);
  return full.cache;
}

void expect_same(const LayerCache& a, const LayerCache& b) {
  EXPECT_EQ(a.radiance, b.radiance);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.surface_id, b.surface_id);
  EXPECT_EQ(a.whole_transmittance, b.whole_transmittance);
  for (size_t t = 0; t < a.whole_transmittance.size(); t += 4)
    if (a.whole_transmittance[t + 3] != 0) {
      EXPECT_EQ(a.whole_radiance[t], b.whole_radiance[t]);
    }
}

// Returns how many layers are farther than `off` from those shaded in full.
uint32_t wrong(const LayerCache& cache, const LayerCache& full, float off) {
  uint32_t count = 0;
  for (size_t t = 0; t < full.distance.size(); ++t) {
    const glm::vec3 apart = glm::abs(rgb(cache.radiance, t) - rgb(full.radiance, t));
    count += std::max({apart.x, apart.y, apart.z}) > off;
  }
  return count;
}

float brightest_of(const LayerCache& cache) {
  float most = 0.0f;
  for (size_t t = 0; t < cache.distance.size(); ++t) most = std::max(most, rgb(cache.radiance, t).x);
  return most;
}

sideray_material_desc tinted_mirror() {
  sideray_material_desc m = blended({0.9f, 0.8f, 0.7f}, 0.5f);
  m.metallic = 1.0f;
  m.roughness = 0.0f;
  return m;
}

// Two panes over the whole view, before a wall of lit stripes that they mirror, one of which may move.
struct Panes {
  TestScene scene;
  uint32_t mover;

  explicit Panes(float brightness = 3.0f) {
    scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, tinted_mirror());
    scene.quad({0, 0, -3}, {50, 0, 2}, {0, 50, 0}, tinted_mirror());
    mover = scene.quad({0.3f, 0, 3.9f}, {0.5f, 0, 0}, {0, 20, 0}, glowing(glm::vec3(brightness)));
    scene.quad({0, 0, 4}, {50, 0, 0}, {0, 50, 0}, plain_material());
    scene.environment({0.2f, 0.3f, 0.4f});
    light({1, 2, 2}, 20.0f);
  }
  void light(glm::vec3 at, float intensity) { scene.lights({point_light(at, intensity)}); }
  void move(double x) {
    const double to[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0, 0};
    scene.scene.move_instances(&mover, 1, to);
  }
};

TEST(ShadingReuse, each_frame_of_an_unmoved_view_shades_an_eighth) {
  Panes panes;
  const auto snapshot = panes.scene.commit();
  const LayerCache full = shaded(snapshot, from({0, 0, 0}));
  ASSERT_GT(std::count_if(full.whole_transmittance.begin(), full.whole_transmittance.end(), [](auto h) { return h != 0; }),
            side * side) << "or no pixel is whole";
  Reusing sequence;
  EXPECT_EQ(sequence.frame(snapshot, from({0, 0, 0}), SequenceStep::first).layers_reused, 0u);
  for (uint32_t i = 0; i < period; ++i) {
    const Counters counters = sequence.frame(snapshot, from({0, 0, 0}));
    EXPECT_EQ(counters.layers_found, all_layers);
    // Cells are 4 pixels wide, and turns a period of cells long: 48 pixels have half a turn more.
    EXPECT_NEAR(static_cast<double>(counters.layers_shaded), all_layers / period, all_layers / 24.0);
    EXPECT_EQ(counters.layers_reused, all_layers - counters.layers_shaded);
  }
}

bool is_kept(const Counters& counters, const LayerCache& cache) {
  const bool kept = counters.rays_primary == 0;
  EXPECT_EQ(std::ranges::count(cache.dirty_tiles, 1) == 0, kept) << "what is kept is not uploaded";
  EXPECT_EQ(counters.layers_found, all_layers);
  return kept;
}

// Once each pixel has had its turn nothing is traced at all, until something changes, be it in the depth alone.
TEST(ShadingReuse, what_stands_still_is_kept_until_something_changes) {
  Panes panes;
  auto snapshot = panes.scene.commit();
  Reusing sequence;
  TraceView view = from({0, 0, 0});
  float depth = 0.0f;
  uint32_t stencil = layers;
  const auto frame = [&](SequenceStep step = SequenceStep::next) {
    return is_kept(sequence.frame(snapshot, view, step, depth, stencil), sequence.cache);
  };
  EXPECT_FALSE(frame(SequenceStep::first));
  const auto settles = [&](const char* change) {
    EXPECT_FALSE(frame()) << change;
    for (uint32_t i = 0; i < period; ++i) EXPECT_FALSE(frame()) << change << ' ' << i;
    snapshot = panes.scene.commit();
    EXPECT_TRUE(frame()) << change << ": a commit that changes nothing is no change";
    expect_same(sequence.cache, shaded(snapshot, view, depth, stencil));
  };
  for (uint32_t i = 1; i < period; ++i) EXPECT_FALSE(frame());
  EXPECT_FALSE(frame());
  EXPECT_TRUE(frame());
  panes.move(2.0);
  snapshot = panes.scene.commit();
  settles("an object moved");
  view = from({0.001, 0, 0});
  settles("the eye moved");
  depth = 1e-9f;
  settles("the depth changed");
  stencil = 3;
  settles("the mask changed");
  panes.light({1, 2, 2}, 10.0f);
  snapshot = panes.scene.commit();
  settles("the lamp is dimmer");
  EXPECT_FALSE(frame(SequenceStep::again)) << "times are those of frames that are traced";
  EXPECT_TRUE(frame()) << "what is drawn for its times is no frame of the sequence";
  EXPECT_FALSE(frame(SequenceStep::first));
}

TEST(ShadingReuse, cuts_lights_and_materials_begin_anew) {
  Panes panes;
  Reusing sequence;
  sequence.frame(panes.scene.commit(), from({0.05, 0, 0}), SequenceStep::first);
  const auto before = panes.scene.commit();
  sequence.frame(before, from({0, 0, 0}), SequenceStep::first);
  expect_same(sequence.cache, shaded(before, from({0, 0, 0})));
  for (const float intensity : {0.0f, 20.0f}) {  // the lamp is off, then elsewhere
    panes.light({-1, 2, 2}, intensity);
    const auto snapshot = panes.scene.commit();
    EXPECT_EQ(sequence.frame(snapshot, from({0, 0, 0})).layers_reused, 0u);
    expect_same(sequence.cache, shaded(snapshot, from({0, 0, 0})));
  }
  sideray_material_desc dark = tinted_mirror();
  dark.base_color[3] = 0.25f;
  panes.scene.scene.replace_material(1, dark);
  const auto snapshot = panes.scene.commit();
  EXPECT_EQ(sequence.frame(snapshot, from({0, 0, 0})).layers_reused, 0u);
  expect_same(sequence.cache, shaded(snapshot, from({0, 0, 0})));
}

// Who jumps without saying so sees mirrors from elsewhere.
TEST(ShadingReuse, what_is_seen_at_another_angle_is_shaded) {
  Panes panes;
  const auto snapshot = panes.scene.commit();
  Reusing sequence;
  sequence.frame(snapshot, from({0, 0, 0}), SequenceStep::first);
  EXPECT_EQ(sequence.frame(snapshot, from({0.5, 0, 0})).layers_reused, 0u);
  expect_same(sequence.cache, shaded(snapshot, from({0.5, 0, 0})));
}

// Nothing that the history compares changes where a thing moves that is mirrored alone. Those shaded in the first frame find
// it; in the second all around them are, and after a period each pixel has been.
TEST(ShadingReuse, what_a_moved_object_changes_is_found_at_once) {
  Panes panes;
  Reusing sequence;
  sequence.frame(panes.scene.commit(), from({0, 0, 0}), SequenceStep::first);
  panes.move(2.0);
  const auto snapshot = panes.scene.commit();
  const LayerCache full = shaded(snapshot, from({0, 0, 0}));
  ASSERT_GT(wrong(sequence.cache, full, bound), all_layers / 20) << "or nothing changed";
  sequence.frame(snapshot, from({0, 0, 0}));
  EXPECT_GT(wrong(sequence.cache, full, bound), 0u) << "or the next frame proves nothing";
  sequence.frame(snapshot, from({0, 0, 0}));
  // An alpha of 1/2 halves what a layer adds to its pixel.
  EXPECT_EQ(wrong(sequence.cache, full, 2 * bound), 0u);
  for (uint32_t i = 2; i < period; ++i) sequence.frame(snapshot, from({0, 0, 0}));
  expect_same(sequence.cache, full);
}

// A change below the bound is not looked for, and still gone after a period.
TEST(ShadingReuse, small_changes_last_a_period) {
  Panes panes(0.9f);
  Reusing sequence(16.0f);
  sequence.frame(panes.scene.commit(), from({0, 0, 0}), SequenceStep::first);
  panes.move(2.0);
  const auto snapshot = panes.scene.commit();
  const LayerCache full = shaded(snapshot, from({0, 0, 0}));
  for (uint32_t i = 0; i < period; ++i) {
    EXPECT_GT(wrong(sequence.cache, full, 0.0f), 0u) << i;
    EXPECT_LT(sequence.frame(snapshot, from({0, 0, 0})).layers_shaded, all_layers / 5);
  }
  expect_same(sequence.cache, full);
}

// While the eye moves, a pixel's light comes from others': an age goes along with it.
TEST(ShadingReuse, no_light_is_older_than_its_bound_where_the_eye_moves) {
  Panes panes(3000.0f);
  panes.light({1, 2, 2}, 0.0f);
  Reusing sequence(1e6f);
  const auto view = [](uint32_t frame) { return from({0.011 * frame, 0.007 * frame, 0}); };
  sequence.frame(panes.scene.commit(), view(0), SequenceStep::first);
  panes.move(1000.0);
  const auto snapshot = panes.scene.commit();
  for (uint32_t i = 1; i <= LayerHistory::oldest + 1u; ++i) sequence.frame(snapshot, view(i));
  // The mover was brighter by far than all else.
  const float brightest = brightest_of(shaded(snapshot, view(LayerHistory::oldest + 1u)));
  ASSERT_LT(brightest, 1.0f);
  EXPECT_LT(brightest_of(sequence.cache), brightest + 0.05f);
}

TEST(ShadingReuse, any_number_of_threads_has_the_same_bits) {
  Panes panes;
  Reusing one(bound, 1), two(bound, 2), five(bound, 5);
  uint64_t reused = 0;
  for (uint32_t i = 0; i < 5; ++i) {
    panes.move(0.1 * i);
    const auto snapshot = panes.scene.commit();
    const TraceView view = from({0.004 * i, 0.003 * i, -0.002 * i});
    const SequenceStep step = i == 0 ? SequenceStep::first : SequenceStep::next;
    reused += one.frame(snapshot, view, step).layers_reused;
    two.frame(snapshot, view, step);
    five.frame(snapshot, view, step);
    expect_same(one.cache, two.cache);
    expect_same(one.cache, five.cache);
  }
  EXPECT_GT(reused, all_layers);
}

// In motion light is taken where four layers around agree: edges of what is mirrored are shaded, and stay sharp.
TEST(ShadingReuse, motion_blurs_nothing_by_more_than_the_bound) {
  Panes panes;
  const auto snapshot = panes.scene.commit();
  Reusing sequence;
  for (uint32_t i = 0; i < 2 * period; ++i) {
    const TraceView view = from({0.004 * i, 0.003 * i, -0.002 * i});
    const Counters counters = sequence.frame(snapshot, view, i == 0 ? SequenceStep::first : SequenceStep::next);
    if (i == 0) continue;
    EXPECT_GT(counters.layers_reused, all_layers / 3);
    // The lattice may miss an edge that comes into a cell, for a frame.
    EXPECT_LT(wrong(sequence.cache, shaded(snapshot, view), 2 * bound), all_layers / 100) << i;
  }
}

// Glass that bends light shows other things as the eye moves, but the same from the same place.
TEST(ShadingReuse, bent_layers_of_an_unmoved_view_are_reused) {
  TestScene scene;
  sideray_material_desc solid = glass();
  solid.thickness = 0.1f;
  solid.double_sided = 0;
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, solid);
  scene.quad({0, 0, -2.5f}, {-50, 0, 0}, {0, 50, 0}, solid);
  for (int i = -8; i <= 8; ++i)
    scene.quad({0.5f * static_cast<float>(i), 0, -4}, {0.1f, 0, 0}, {0, 20, 0}, glowing(glm::vec3(1.0f + 0.1f * static_cast<float>(i))));
  const auto snapshot = scene.commit();
  const LayerCache full = shaded(snapshot, from({0, 0, 0}));
  ASSERT_GT(std::count_if(full.distance.begin(), full.distance.end(), [](float d) { return d < 0.0f; }), side * side / 2)
      << "or nothing bends";
  Reusing sequence;
  sequence.frame(snapshot, from({0, 0, 0}), SequenceStep::first);
  for (uint32_t i = 0; i < period; ++i) {
    EXPECT_GT(sequence.frame(snapshot, from({0, 0, 0})).layers_reused, 0u);
    EXPECT_EQ(wrong(sequence.cache, full, 0.01f), 0u) << i;
  }
}

}  // namespace
}  // namespace sideray::rt::shading_reuse_test
