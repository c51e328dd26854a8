#include "lab/picking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "lab/candidates.h"

namespace sideray::lab {
namespace {

using testing::ElementsAre;

struct Truth {
  std::optional<double> error;
  double small_ms, ms;
};

struct Outcome {
  PickStep step;
  size_t candidate;
  std::vector<size_t> timed;
};

// Asks for times as the program does.
Outcome pick(const std::vector<Truth>& truths, const CostBounds& bounds) {
  std::vector<Candidate> candidates;
  for (const Truth& t : truths) candidates.push_back({t.error, t.small_ms, {}});
  Outcome outcome{};
  for (;;) {
    const Pick next = next_pick(candidates, bounds);
    outcome.step = next.step, outcome.candidate = next.candidate;
    if (next.step != PickStep::time) return outcome;
    EXPECT_FALSE(candidates[next.candidate].ms) << "asked twice";
    outcome.timed.push_back(next.candidate);
    candidates[next.candidate].ms = truths[next.candidate].ms;
  }
}

// The cheaper, the more wrong; of all a whole frame takes ten times as long.
const std::vector<Truth> front{{0.20, 1, 10}, {0.10, 2, 20}, {0.05, 4, 40}, {0.02, 8, 80}, {0.01, 16, 160}};

TEST(Picking, AnErrorPicksTheCheapestThatHoldsIt) {
  const Outcome outcome = pick(front, {{}, 0.05});
  EXPECT_EQ(outcome.step, PickStep::picked);
  EXPECT_EQ(outcome.candidate, 2u);
  EXPECT_THAT(outcome.timed, ElementsAre(2)) << "the others cannot win";
  EXPECT_EQ(pick(front, {{}, 1.0}).candidate, 0u);
}

TEST(Picking, ATimePicksTheMostAccurateThatHoldsIt) {
  const Outcome outcome = pick(front, {50.0, {}});
  EXPECT_EQ(outcome.step, PickStep::picked);
  EXPECT_EQ(outcome.candidate, 2u);
  EXPECT_EQ(pick(front, {1e6, {}}).candidate, 4u);
  EXPECT_THAT(pick(front, {1e6, {}}).timed, ElementsAre(4));
}

TEST(Picking, BothPickTheCheapestThatHoldsBoth) {
  EXPECT_EQ(pick(front, {100.0, 0.05}).candidate, 2u);
  const Outcome slow = pick(front, {30.0, 0.05});
  EXPECT_EQ(slow.step, PickStep::failed);
  EXPECT_EQ(slow.candidate, 2u) << "what holds the error is too slow";
}

TEST(Picking, WhatFailsNamesTheNearest) {
  const Outcome wrong = pick(front, {{}, 0.001});
  EXPECT_EQ(wrong.step, PickStep::failed);
  EXPECT_EQ(wrong.candidate, 4u) << "the most accurate";
  EXPECT_THAT(wrong.timed, ElementsAre(4)) << "so that its time can be named";
  const Outcome slow = pick(front, {5.0, {}});
  EXPECT_EQ(slow.step, PickStep::failed);
  EXPECT_EQ(slow.candidate, 0u) << "the fastest";
}

TEST(Picking, ReducedFramesMayMisleadALittle) {
  // The second looks dearer and is cheaper.
  const Outcome outcome = pick({{0.01, 10, 100}, {0.01, 11, 90}, {0.01, 30, 80}}, {{}, 0.01});
  EXPECT_EQ(outcome.candidate, 1u);
  EXPECT_THAT(outcome.timed, ElementsAre(0, 1)) << "three times as dear is beyond doubt";
}

TEST(Picking, WhatIsNotKnownHoldsNoError) {
  EXPECT_EQ(pick({{{}, 1, 1}, {0.5, 2, 2}}, {{}, 0.5}).candidate, 1u);
  EXPECT_EQ(pick({{{}, 1, 1}, {0.5, 2, 2}}, {10.0, {}}).candidate, 1u);
  EXPECT_EQ(pick({{{}, 1, 1}}, {{}, 0.5}).step, PickStep::failed);
}

TEST(Picking, TheFirstOfEquals) {
  EXPECT_EQ(pick({{0.1, 1, 10}, {0.1, 1, 10}}, {{}, 0.1}).candidate, 0u);
  EXPECT_EQ(pick({{0.1, 1, 10}, {0.1, 1, 10}}, {20.0, {}}).candidate, 0u);
}

size_t count_of(const std::vector<Configuration>& list, const char* option, const char* value) {
  size_t count = 0;
  for (const Configuration& c : list) count += c.contains(option) && c.at(option) == value;
  return count;
}

bool has(const std::vector<Configuration>& list, const Configuration& wanted) {
  return std::find(list.begin(), list.end(), wanted) != list.end();
}

const SweepScene glass{.translucent_objects = 4, .traceable_objects = 4, .layered_objects = 4, .lights = 1};

TEST(CandidateConfigurations, SuitTheScene) {
  const auto all = candidate_configurations(glass, {});
  for (const char* shadows : {"off", "map", "exact"}) {
    EXPECT_TRUE(has(all, {{"translucency", "raster"}, {"shadows", shadows}})) << shadows;
    EXPECT_TRUE(has(all, {{"translucency", "raytraced"}, {"layers", "unlimited"}, {"shadows", shadows}})) << shadows;
    EXPECT_TRUE(
        has(all, {{"translucency", "hybrid"}, {"layers", "2"}, {"cache-rate", "quarter"}, {"shadows", shadows}}))
        << shadows;
  }
  EXPECT_EQ(count_of(all, "shadows", "inexact"), 0u) << "nothing sways";
  EXPECT_EQ(count_of(all, "ao", "on") + count_of(all, "translucency", "reference"), 0u);
  const auto opaque = candidate_configurations({.lights = 1}, {});
  EXPECT_EQ(count_of(opaque, "translucency", "hybrid") + count_of(opaque, "translucency", "raytraced"), 0u);
  EXPECT_TRUE(has(opaque, {{"shadows", "map"}}));
  SweepScene forest = glass;
  forest.swaying_objects = forest.swaying_copies = 100;
  EXPECT_TRUE(has(candidate_configurations(forest, {}), {{"translucency", "raster"}, {"shadows", "inexact"}}));
}

TEST(CandidateConfigurations, AreAllThatAChartWouldDraw) {
  const auto all = candidate_configurations(glass, {});
  const auto is_left_out = [](const Configuration& point) {
    for (const char* option : {"ao", "reflections", "mask", "step", "match"})
      if (point.contains(option)) return true;
    return point.contains("translucency") && point.at("translucency") == "reference";
  };
  for (const Configuration& point : default_sweep(Sweep::all, glass).configurations)
    EXPECT_NE(has(all, point), is_left_out(point)) << describe(point);
}

TEST(CandidateConfigurations, LeaveGivenOptionsAlone) {
  const auto fixed = candidate_configurations(glass, {{"layers", "3"}, {"shadows", "off"}});
  for (const Configuration& c : fixed) EXPECT_FALSE(c.contains("layers") || c.contains("shadows"));
  EXPECT_TRUE(has(fixed, {{"translucency", "hybrid"}, {"cache-rate", "quarter"}}));
  for (const Configuration& c : candidate_configurations(glass, {{"translucency", "raytraced"}}))
    EXPECT_FALSE(c.contains("translucency"));
}

}  // namespace
}  // namespace sideray::lab
