// Compares steppers along a ray, also for surfaces in one plane or nearly so, and tests the count of layers that hold a
// surface twice.
#include <gmock/gmock.h>
#include <sideray/diagnostics.h>

#include <bit>
#include <map>
#include <random>

#include "model/failure.h"
#include "rt/layers/layer_check.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

TraceView view_along_z() {
  return perspective({0, 0, 0}, {0, 0, -1}, 0.8, 1.0);
}

// Panes of glass at random depths from 2 to 30, some in the plane of another, turned by up to a radian.
void add_random_panes(TestScene& scene, uint32_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> depth(2.0f, 30.0f), turn(-0.5f, 0.5f);
  glm::vec3 center(0), u(0), v(0);
  for (uint32_t i = 0; i < count; ++i) {
    if (i % 3 != 2) {
      const float a = turn(random), b = turn(random);
      center = {0, 0, -depth(random)};
      u = 40.0f * glm::vec3(std::cos(a), 0, std::sin(a));
      v = 40.0f * glm::vec3(0, std::cos(b), std::sin(b));
    }
    scene.quad(center, u, v, blended({0.5f, 0.8f, 1.0f}, 0.5f));
  }
}

LayerCache cache_by(Tracer& tracer, const TraceView& view, uint32_t size, sideray_step step, uint32_t layers) {
  TestFrame frame(view, size, size, layers);
  frame.request.step = step;
  LayerCache cache;
  tracer.trace_cache(frame.get(), cache);
  return cache;
}

TEST(Steps, retrace_gives_the_same_bits_as_multihit) {
  TestScene scene;
  add_random_panes(scene, 24);
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  for (const uint32_t layers : {1u, 2u, 5u, 8u}) {
    const LayerCache a = cache_by(tracer, view_along_z(), 48, SIDERAY_STEP_MULTIHIT, layers);
    const LayerCache b = cache_by(tracer, view_along_z(), 48, SIDERAY_STEP_RETRACE, layers);
    EXPECT_EQ(a.distance, b.distance) << layers;
    EXPECT_EQ(a.surface_id, b.surface_id) << layers;
    EXPECT_EQ(a.radiance, b.radiance) << layers;
  }
  CompositeImage images[2];
  for (const sideray_step step : {SIDERAY_STEP_MULTIHIT, SIDERAY_STEP_RETRACE}) {
    TestFrame frame(view_along_z(), 48, 48, 0);
    frame.request.step = step;
    tracer.trace_composite(frame.get(), images[step]);
  }
  EXPECT_EQ(images[0].radiance, images[1].radiance);
  EXPECT_EQ(images[0].transmittance, images[1].transmittance);
}

// Returns the distances that listing 50-1 finds: MinT grows by each distance found.
std::vector<float> listed(const std::vector<float>& distances) {
  std::vector<float> found;
  float start = 0.0f;
  for (const float d : distances) {
    if (d < start) continue;
    found.push_back(d);
    start += d * (1.0f + 1e-6f);
  }
  return found;
}

// The share of events that it loses of eight random layers in 2 to 30.
TEST(Steps, the_listing_loses_what_its_arithmetic_skips) {
  std::map<uint32_t, double> lost, wanted;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> depth(2.0f, 30.0f);
  for (int round = 0; round < 40; ++round) {
    TestScene scene;
    for (int i = 0; i < 8; ++i) scene.quad({0, 0, -depth(random)}, {60, 0, 0}, {0, 60, 0}, blended({1, 1, 1}, 0.5f));
    Tracer tracer({.threads = 1, .isa = ""});
    tracer.set_scene(scene.commit());
    const LayerCache truth = cache_by(tracer, view_along_z(), 8, SIDERAY_STEP_MULTIHIT, 8);
    const LayerCache cache = cache_by(tracer, view_along_z(), 8, SIDERAY_STEP_LISTING, 8);
    for (size_t pixel = 0; pixel < 64; ++pixel) {
      std::vector<float> distances, found;
      for (size_t k = 0; k < 8; ++k) distances.push_back(truth.distance[64 * k + pixel]);
      for (size_t k = 0; k < 8 && cache.distance[64 * k + pixel] > 0; ++k)
        found.push_back(cache.distance[64 * k + pixel]);
      ASSERT_EQ(found, listed(distances));
      for (const uint32_t events : {2u, 3u, 4u, 8u}) {
        wanted[events] += events;
        lost[events] += std::max(0.0, events - static_cast<double>(found.size()));
      }
    }
  }
  for (const auto& [events, count] : lost)
    printf("listing 50-1, %u events: %.1f %% of hits lost\n", events, 100 * count / wanted[events]);
  EXPECT_EQ(lost[2], 0.0);
  EXPECT_GT(lost[4] / wanted[4], 0.05);
  EXPECT_GT(lost[8] / wanted[8], 0.4);
}

// Two panes a gap apart: who finds both, once each, and in which order.
struct Pair {
  double both = 0, nearer_first = 0, pixels = 0;
};

Pair look_at_pair(Tracer& tracer, sideray_step step, uint32_t nearer_id) {
  const LayerCache cache = cache_by(tracer, perspective({0.3, 0.2, 4}, {0, 0, 0}, 0.5, 1.0), 64, step, 4);
  Pair result;
  const size_t plane = 64 * 64;
  for (size_t i = 0; i < plane; ++i) {
    EXPECT_EQ(cache.distance[2 * plane + i], 0.0f) << "no third surface";
    const bool both = cache.distance[plane + i] > 0 && cache.surface_id[i] != cache.surface_id[plane + i];
    result.both += both;
    result.nearer_first += both && cache.surface_id[i] == nearer_id;
    result.pixels += 1;
  }
  return result;
}

// In units of the last place of the panes' z, 1: exact duplicates, the next float, and relative gaps of 1e-6.
class PanesAGapApart : public testing::TestWithParam<std::tuple<int, bool, bool>> {};

TEST_P(PanesAGapApart, are_both_found_once_in_one_order) {
  const auto [ulps, mirrored, nearer_has_lower_id] = GetParam();
  float back = -1.0f;
  for (int i = 0; i < ulps; ++i) back = std::nextafter(back, -2.0f);
  TestScene scene;
  const float first = nearer_has_lower_id ? -1.0f : back, second = nearer_has_lower_id ? back : -1.0f;
  scene.quad({0, 0, first}, {9, 0, 0}, {0, 9, 0}, blended({1, 1, 1}, 0.5f));
  // The second is a decal: its corners are others, and it may be the same mesh turned inside out.
  const std::vector<glm::vec3> corners{{-7, -8, second}, {8, -7, second}, {7, 8, second}, {-8, 7, second}};
  const glm::dmat4 place = glm::scale(glm::dmat4(1.0), glm::dvec3(mirrored ? -1.0 : 1.0, 1.0, 1.0));
  scene.add(corners, std::vector<glm::vec2>(4), {0, 1, 2, 0, 2, 3}, blended({1, 1, 1}, 0.5f), place);
  const std::shared_ptr<const model::Snapshot> snapshot = scene.commit();
  // Coplanar ones are in the order of their ids.
  const uint32_t nearer_id = ulps == 0 || nearer_has_lower_id ? 1 : 2;
  for (const char* isa : {"sse4.2", "avx2", "avx512"}) {
    std::unique_ptr<Tracer> tracer;
    try {
      tracer = std::make_unique<Tracer>(TracerConfig{.threads = 2, .isa = isa});
    } catch (const Failure&) {
      continue;  // not on this machine
    }
    tracer->set_scene(snapshot);
    for (const sideray_step step : {SIDERAY_STEP_MULTIHIT, SIDERAY_STEP_RETRACE}) {
      const Pair found = look_at_pair(*tracer, step, nearer_id);
      EXPECT_EQ(found.both, found.pixels) << isa << ", step " << step;
      EXPECT_EQ(found.nearer_first, found.pixels) << isa << ", step " << step;
    }
    const Pair listing = look_at_pair(*tracer, SIDERAY_STEP_LISTING, nearer_id);
    printf("%d ulp, %s: listing finds both in %.0f %% of pixels\n", ulps, isa, 100 * listing.both / listing.pixels);
    EXPECT_LT(listing.both, 0.01 * listing.pixels) << "or this scene tests nothing";
  }
}

INSTANTIATE_TEST_SUITE_P(Gaps, PanesAGapApart,
                         testing::Combine(testing::Values(0, 1, 2, 8, 17), testing::Bool(), testing::Bool()));

// More coplanar surfaces than one traversal returns at first, and all of them through every stepper.
TEST(CoplanarLayers, are_all_returned) {
  TestScene scene;
  for (int i = 0; i < 40; ++i) scene.quad({0, 0, -3}, {20, 0, 0}, {0, 20, 0}, blended({1, 1, 1}, 0.1f));
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(view_along_z(), 24, 24, 8, 5);
  const LayerTruth truth = tracer.trace_truth(frame.get());
  ASSERT_EQ(truth.first.size(), 24u * 24 + 1);
  for (size_t i = 0; i < 24 * 24; ++i) {
    ASSERT_EQ(truth.first[i + 1] - truth.first[i], 40u) << "whatever the count in the stencil says";
    for (uint32_t k = 0; k < 40; ++k) EXPECT_EQ(truth.surfaces[truth.first[i] + k].y, k + 1);
  }
}

// 200 panes: more than a traversal returns, so that the count goes through several rounds.
TEST(LayerTruth, has_every_surface_of_deep_pixels) {
  TestScene scene;
  for (int i = 0; i < 200; ++i)
    scene.quad({0, 0, -3 - 0.01f * static_cast<float>(i)}, {20, 0, 0}, {0, 20, 0}, blended({1, 1, 1}, 0.1f));
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame(view_along_z(), 8, 8, 2);
  const LayerTruth truth = tracer.trace_truth(frame.get());
  LayerCache cache;
  tracer.trace_cache(frame.get(), cache);
  for (size_t i = 0; i < 64; ++i) {
    ASSERT_EQ(truth.first[i + 1] - truth.first[i], 200u);
    EXPECT_EQ(std::bit_cast<float>(truth.surfaces[truth.first[i] + 1].x), cache.distance[64 + i]);
  }
  EXPECT_EQ(count_duplicated(cache, truth), 0u);
}

TEST(LayerTruth, tells_layers_that_are_one_surface) {
  // One pixel with two coplanar surfaces of id 4 and one of id 5 behind them.
  const auto bits = [](float d) { return std::bit_cast<uint32_t>(d); };
  const LayerTruth truth{1, 1, {0, 3}, {{bits(1.0f), 4}, {bits(1.0f), 4}, {bits(2.0f), 5}}};
  LayerCache cache;
  cache.width = cache.height = 1;
  cache.layers = 4;
  cache.surface_id = {4, 4, 5, 0};
  cache.distance = {1.0f, 1.0f, 2.0f, 0.0f};
  EXPECT_EQ(count_duplicated(cache, truth), 0u);
  cache.surface_id = {4, 4, 4, 5};
  cache.distance = {1.0f, 1.0f, 1.0f, 2.0f};
  EXPECT_EQ(count_duplicated(cache, truth), 1u);
  cache.surface_id = {5, 5, 5, 0};
  cache.distance = {2.0f, 2.00001f, 1.9999f, 0.0f};
  EXPECT_EQ(count_duplicated(cache, truth), 2u);
}

}  // namespace
}  // namespace sideray::rt
