#include "lab/prediction/prediction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace sideray::lab {
namespace {

constexpr double small = 320.0 * 180, large = 640.0 * 360, whole = 1280.0 * 720;

TEST(Prediction, CountsOfAreasAndEdgesComeOutExact) {
  const auto area = [](double n) { return 0.37 * n; };
  const auto edge = [](double n) { return 12.5 * std::sqrt(n); };
  const auto both = [&](double n) { return area(n) + edge(n); };
  const auto foretold = [](const auto& f) { return count_at(small, f(small), large, f(large), whole); };
  EXPECT_NEAR(foretold(area), area(whole), 1e-6 * area(whole));
  EXPECT_NEAR(foretold(edge), edge(whole), 1e-6 * edge(whole));
  EXPECT_NEAR(foretold(both), both(whole), 1e-6 * both(whole));
  // Edges that surfaces lose: the outer rim of what has an inside.
  const auto inner = [&](double n) { return area(n) - edge(n); };
  EXPECT_NEAR(foretold(inner), inner(whole), 1e-6 * inner(whole));
}

TEST(Prediction, ErrorsOfTheFramesGrowLittle) {
  const double exact = count_at(small, 0.5 * small, large, 0.5 * large, whole);
  EXPECT_NEAR(count_at(small, 0.5 * small, large, 0.51 * large, whole) / exact, 1.03, 1e-6);
  EXPECT_NEAR(count_at(small, 0.51 * small, large, 0.5 * large, whole) / exact, 0.99, 1e-6);
}

TEST(Prediction, NothingIsLessThanNothing) {
  EXPECT_EQ(count_at(small, 10, large, 0, whole), 0);
  EXPECT_EQ(count_at(small, 0, large, 0, whole), 0);
  EXPECT_EQ(time_at(small, 0, large, 0, whole), 0);
}

TEST(Prediction, TimesAreFixedAndAPixel) {
  const auto line = [](double n) { return 3.0 + 2e-5 * n; };
  EXPECT_NEAR(time_at(small, line(small), large, line(large), whole), line(whole), 1e-9);
  // Noise never makes pixels pay back, nor a frame begin below nothing.
  EXPECT_EQ(time_at(small, 5.0, large, 4.9, whole), 4.9);
  EXPECT_NEAR(time_at(small, 1.0, large, 8.0, whole), 8.0 * whole / large, 1e-9);
}

TEST(Prediction, AFrameDrawnWholeIsWhatItWas) {
  EXPECT_EQ(count_at(small, 7, whole, 1234, whole), 1234);
  EXPECT_EQ(time_at(whole, 7, whole, 12.5, whole), 12.5);
}

TEST(Prediction, ReducedFramesHaveEnoughPixels) {
  const ProbeSizes usual = probe_sizes({1280, 720}), few = probe_sizes({320, 180}), tiny = probe_sizes({64, 36});
  EXPECT_EQ(usual.small.width, 320u);
  EXPECT_EQ(usual.small.height, 180u);
  EXPECT_EQ(usual.large.width, 640u);
  EXPECT_NEAR(static_cast<double>(few.small.pixels()), 40000.0, 400.0);
  EXPECT_EQ(few.large.pixels(), 320u * 180u);
  EXPECT_EQ(tiny.small.pixels(), 64u * 36u);
  EXPECT_EQ(probe_sizes({16384, 1}).small.height, 1u);
}

Probe some_probe() {
  Probe probe;
  probe.small.pixels = 57600, probe.large.pixels = 230400;
  probe.small.work = {100, 200, 300, 400, 500, 600, 700, 0, 150};
  probe.large.work = {400, 800, 1200, 1600, 2000, 2400, 2800, 0, 600};
  probe.small.stage_ms[SIDERAY_STAGE_TOTAL_FRAME] = 2, probe.large.stage_ms[SIDERAY_STAGE_TOTAL_FRAME] = 5;
  return probe;
}

TEST(Prediction, StaysWithinTheBoundsAndTakesTheCacheFromThem) {
  sideray_plan_work most{};
  most.rays_primary = 1000;
  most.rays_reflection = most.rays_shadow = most.rays_ao = most.rays_bounce = SIDERAY_UNBOUNDED;
  most.bytes_readback = most.bytes_upload = SIDERAY_UNBOUNDED;
  most.bytes_cache = 4242;
  const FrameCost cost = predict(some_probe(), 921600, most);
  EXPECT_EQ(cost.work.rays_primary, 1000u);
  EXPECT_EQ(cost.work.rays_reflection, 3200u);
  EXPECT_EQ(cost.work.rays_bounce, 2400u);
  EXPECT_EQ(cost.work.fragments, 0u) << "bounded by 0";
  EXPECT_EQ(cost.work.bytes_upload, 11200u);
  EXPECT_EQ(cost.work.bytes_cache, 4242u);
  EXPECT_NEAR(cost.ms(), 17.0, 1e-9);
  const FrameCost twice = predict(some_probe(), 921600, most, 2);
  EXPECT_EQ(twice.work.rays_reflection, 6400u);
  EXPECT_EQ(twice.work.rays_bounce, 4800u);
  EXPECT_EQ(twice.work.bytes_cache, 4242u);
  EXPECT_NEAR(twice.ms(), 34.0, 1e-9);
}

TEST(Prediction, ProbesAreReadBack) {
  const Probe probe = some_probe();
  const std::optional<Probe> read = parse_probe(to_json(probe));
  ASSERT_TRUE(read);
  EXPECT_EQ(to_json(*read), to_json(probe));
  EXPECT_EQ(read->large.work.bytes_upload, 2800u);
  for (const char* text : {"{}", "[]", "3", R"({"small": {}, "large": {}})"})
    EXPECT_FALSE(parse_probe(nlohmann::json::parse(text))) << text;
  nlohmann::json without = to_json(probe);
  without["large"].erase("fragments");
  EXPECT_FALSE(parse_probe(without));
  nlohmann::json swapped = {{"small", to_json(probe)["large"]}, {"large", to_json(probe)["small"]}};
  EXPECT_FALSE(parse_probe(swapped));
}

}  // namespace
}  // namespace sideray::lab
