#include "lab/prediction/picking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "lab/chart/candidates.h"

namespace sideray::lab {
namespace {

using testing::ElementsAre;
using testing::UnorderedElementsAre;

struct Truth {
  std::optional<double> error;
  double small_ms, ms;
  size_t drawing = 0, shadows = 0, kind = 0;
  std::optional<double> drawn_ms = {};  // of the whole frame; empty: as foretold
};

struct Outcome {
  PickStep step;
  size_t candidate;
  std::vector<size_t> looked_at, timed, drawn;
  Correction correction;
};

// Measures as the program does.
Outcome pick(const std::vector<Truth>& truths, const CostBounds& bounds) {
  std::vector<Candidate> candidates;
  for (const Truth& t : truths) candidates.push_back({t.drawing, t.shadows, t.kind, {}, {}, {}});
  Outcome outcome{};
  for (;;) {
    const Pick next = next_pick(candidates, bounds);
    outcome.step = next.step, outcome.candidate = next.candidate;
    Candidate& candidate = candidates[next.candidate];
    const Truth& truth = truths[next.candidate];
    if (next.step == PickStep::look) {
      EXPECT_FALSE(candidate.look) << "asked twice";
      outcome.looked_at.push_back(next.candidate);
      candidate.look = Look{truth.small_ms, truth.error};
    } else if (next.step == PickStep::time) {
      EXPECT_TRUE(candidate.look && !candidate.ms) << "too early, or asked twice";
      outcome.timed.push_back(next.candidate);
      candidate.ms = truth.ms;
    } else if (next.step == PickStep::draw) {
      EXPECT_TRUE(candidate.ms && !candidate.drawn_ms) << "too early, or asked twice";
      outcome.drawn.push_back(next.candidate);
      candidate.drawn_ms = truth.drawn_ms.value_or(truth.ms);
    } else {
      EXPECT_TRUE(candidate.look && candidate.ms) << "not measured";
      EXPECT_TRUE(next.step == PickStep::failed || !bounds.most_ms || candidate.drawn_ms) << "not drawn";
      outcome.correction = correction(candidates, bounds);
      return outcome;
    }
  }
}

// The cheaper, the more wrong; of all a whole frame takes ten times as long.
const std::vector<Truth> front{
    {0.20, 1, 10, 0}, {0.10, 2, 20, 1}, {0.05, 4, 40, 2}, {0.02, 8, 80, 3}, {0.01, 16, 160, 4}};

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

TEST(Picking, ATimeIsNotSpentOnWhatHardlyDiffers) {
  EXPECT_EQ(pick({{0.100, 10, 100, 0}, {0.101, 4, 40, 1}, {0.110, 2, 20, 2}}, {1e6, {}}).candidate, 1u);
  EXPECT_EQ(pick({{0.100, 10, 100, 0}, {0.101, 4, 40, 1}, {0.110, 2, 20, 2}}, {30.0, {}}).candidate, 2u);
  EXPECT_EQ(pick({{0.100, 10, 100, 0}, {0.103, 4, 40, 1}}, {1e6, {}}).candidate, 0u);
}

TEST(Picking, BothPickTheCheapestThatHoldsBoth) {
  EXPECT_EQ(pick(front, {100.0, 0.05}).candidate, 2u);
  const Outcome slow = pick(front, {30.0, 0.05});
  EXPECT_EQ(slow.step, PickStep::failed);
  EXPECT_EQ(slow.candidate, 2u) << "what holds the error is too slow";
}

// Whole frames take so many times what reduced ones foretold.
std::vector<Truth> drawn(std::vector<Truth> truths, double scale) {
  for (Truth& t : truths) t.drawn_ms = scale * t.ms;
  return truths;
}

TEST(Picking, ATimeIsHeldByAWholeFrame) {
  const Outcome outcome = pick(front, {50.0, {}});
  EXPECT_THAT(outcome.drawn, ElementsAre(2)) << "the one that is picked, once";
  EXPECT_EQ(outcome.correction.count, 0u);
  EXPECT_EQ(outcome.correction.scale, 1.0);
  EXPECT_THAT(pick(front, {{}, 0.05}).drawn, ElementsAre()) << "there is no bound on the time";
  EXPECT_EQ(pick(drawn(front, 0.5), {50.0, {}}).candidate, 2u) << "what is faster than foretold is not chosen anew";
}

TEST(Picking, AMissedTimeIsChosenAnew) {
  // 40 foretold are 52; of 20 foretold, which are 26 by the same factor, the bound is held.
  const Outcome outcome = pick(drawn(front, 1.3), {50.0, {}});
  EXPECT_EQ(outcome.step, PickStep::picked);
  EXPECT_EQ(outcome.candidate, 1u);
  EXPECT_THAT(outcome.drawn, ElementsAre(2, 1));
  EXPECT_EQ(outcome.correction.count, 1u);
  EXPECT_DOUBLE_EQ(outcome.correction.scale, 1.3);
}

TEST(Picking, TheFactorHoldsForAll) {
  // By the factor of the first the second misses too, and is not drawn for it.
  const std::vector<Truth> near = drawn({{0.01, 10, 100, 0}, {0.02, 9.5, 95, 1}, {0.04, 5, 50, 2}}, 1.2);
  EXPECT_THAT(pick(near, {101.0, {}}).drawn, ElementsAre(0, 2));
}

TEST(Picking, WhatMissesAgainIsScaledMore) {
  std::vector<Truth> truths = front;
  truths[3].drawn_ms = 101;
  truths[2].drawn_ms = 120;
  truths[1].drawn_ms = 50;
  const Outcome outcome = pick(truths, {100.0, {}});
  EXPECT_THAT(outcome.drawn, ElementsAre(3, 2, 1));
  EXPECT_EQ(outcome.candidate, 1u);
  EXPECT_EQ(outcome.correction.count, 2u);
  EXPECT_DOUBLE_EQ(outcome.correction.scale, 3.0);
}

// Every frame takes a little more than the bound, so that factors alone would try one after the other.
std::vector<Truth> misleading() {
  std::vector<Truth> truths;
  for (size_t i = 0; i < 20; ++i) {
    const double ms = 100 - 4.0 * static_cast<double>(i);
    truths.push_back({0.01 * static_cast<double>(i + 1), 0.1 * ms, ms, i, 0, 0, 100.5});
  }
  return truths;
}

TEST(Picking, ItIsCorrectedAFewTimes) {
  std::vector<Truth> truths = misleading();
  truths.back().drawn_ms = 99;
  const Outcome outcome = pick(truths, {100.0, {}});
  EXPECT_EQ(outcome.step, PickStep::picked);
  EXPECT_EQ(outcome.candidate, 19u) << "the fastest is the last that is tried";
  EXPECT_EQ(outcome.drawn.size(), most_corrections + 1);
  EXPECT_EQ(outcome.correction.count, most_corrections);
}

TEST(Picking, WhatMissedIsNeverPicked) {
  const Outcome outcome = pick(misleading(), {100.0, {}});
  EXPECT_EQ(outcome.step, PickStep::failed);
  EXPECT_EQ(outcome.drawn.size(), most_corrections + 1);
  for (double scale = 0.5; scale < 12; scale *= 1.1) {
    const std::vector<Truth> truths = drawn(front, scale);
    const Outcome scaled = pick(truths, {100.0, {}});
    EXPECT_EQ(scaled.step == PickStep::picked, 10 * scale <= 100) << scale << ": the fastest holds, or nothing does";
    if (scaled.step == PickStep::picked) {
      EXPECT_LE(*truths[scaled.candidate].drawn_ms, 100);
    }
    EXPECT_LE(scaled.drawn.size(), most_corrections + 1);
  }
}

TEST(Picking, BothAreHeldByAWholeFrame) {
  EXPECT_THAT(pick(drawn(front, 1.1), {50.0, 0.05}).drawn, ElementsAre(2));
  const Outcome slow = pick(drawn(front, 1.3), {50.0, 0.05});
  EXPECT_EQ(slow.step, PickStep::failed) << "nothing that holds the error is foretold to be faster";
  EXPECT_EQ(slow.candidate, 2u);
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
  // The second looks dearer and is cheaper, within what the growth of one kind may differ by.
  const Outcome outcome = pick({{0.01, 10, 100}, {0.01, 11, 90}, {0.01, 30, 80}}, {{}, 0.01});
  EXPECT_EQ(outcome.candidate, 1u);
  EXPECT_THAT(outcome.timed, ElementsAre(0, 1)) << "three times as dear is beyond doubt";
}

TEST(Picking, KindsMayGrowDifferently) {
  // Frames of the second kind hardly grow.
  const std::vector<Truth> truths{{0.01, 10, 100, 0, 0, 0}, {0.01, 14, 60, 1, 0, 1}};
  EXPECT_EQ(pick(truths, {{}, 0.01}).candidate, 1u);
  EXPECT_THAT(pick(truths, {{}, 0.01}).timed, ElementsAre(0, 1));
}

// Three ways of drawing with three of shadows, most of whose errors and times are sums.
std::vector<Truth> crossed() {
  const double drawing_errors[] = {0.02, 0.05, 0.10}, drawing_ms[] = {8, 4, 2};
  const double shadow_errors[] = {0.00, 0.03, 0.20}, shadow_ms[] = {6, 3, 1};
  std::vector<Truth> truths;
  for (size_t d = 0; d < 3; ++d)
    for (size_t s = 0; s < 3; ++s) {
      const double ms = drawing_ms[d] + shadow_ms[s];
      truths.push_back({drawing_errors[d] + shadow_errors[s], ms, 10 * ms, d, s, 0});
    }
  return truths;
}

TEST(Picking, CombinationsAreLookedAtWhereTheyMayWin) {
  const std::vector<Truth> truths = crossed();
  const Outcome outcome = pick(truths, {{}, 0.085});
  EXPECT_EQ(outcome.candidate, 4u) << "the second of each: 0.08 in 70 ms; the third drawing has 0.10 at least";
  EXPECT_THAT(outcome.looked_at, UnorderedElementsAre(0, 1, 2, 3, 6, 4)) << "the two axes, and the winner";
  EXPECT_THAT(outcome.timed, ElementsAre(4));
}

TEST(Picking, WhatCombinesWorseThanExpectedIsNotPicked) {
  std::vector<Truth> truths = crossed();
  truths[4].error = 0.5;
  const Outcome outcome = pick(truths, {{}, 0.085});
  EXPECT_EQ(outcome.candidate, 3u) << "0.05 in 100 ms";
  EXPECT_THAT(outcome.looked_at, testing::Contains(4u));
  truths[4].error = 0.092;
  EXPECT_EQ(pick(truths, {{}, 0.085}).candidate, 3u) << "what was seen counts, without a margin";
}

TEST(Picking, WhatCombinesALittleBetterIsPicked) {
  std::vector<Truth> truths = crossed();
  truths[4].error = 0.074;
  EXPECT_EQ(pick(truths, {{}, 0.075}).candidate, 4u) << "its parts' sum is 0.08";
}

TEST(Picking, ATimePicksAmongCombinationsToo) {
  const Outcome outcome = pick(crossed(), {75.0, {}});
  EXPECT_EQ(outcome.candidate, 4u) << "0.08 in 70 ms; the third drawing with the first shadows has 0.10 in 80";
  EXPECT_EQ(outcome.step, PickStep::picked);
}

TEST(Picking, WhatHasNoPartsIsLookedAtItself) {
  std::vector<Truth> truths = crossed();
  truths.push_back({0.5, 1, 10, 7, 1, 0});
  EXPECT_THAT(pick(truths, {{}, 0.085}).looked_at, testing::Contains(9u));
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

size_t count_of(const std::vector<CandidateConfiguration>& list, const char* option, const char* value) {
  size_t count = 0;
  for (const auto& [c, drawing, shadows] : list) count += c.contains(option) && c.at(option) == value;
  return count;
}

bool has(const std::vector<CandidateConfiguration>& list, const Configuration& wanted) {
  return std::any_of(list.begin(), list.end(), [&](const auto& c) { return c.configuration == wanted; });
}

bool has_at_least(const std::vector<CandidateConfiguration>& list, const Configuration& wanted) {
  return std::any_of(list.begin(), list.end(), [&](const auto& c) {
    return std::includes(c.configuration.begin(), c.configuration.end(), wanted.begin(), wanted.end());
  });
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
  EXPECT_EQ(count_of(all, "ambient", "ao") + count_of(all, "translucency", "reference"), 0u);
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
    for (const char* option : {"ambient", "reflections", "mask", "step", "match"})
      if (point.contains(option)) return true;
    return (point.contains("translucency") && point.at("translucency") == "reference") ||
           (point.contains("oit") && point.at("oit") == "peel");
  };
  for (const Configuration& point : default_sweep(Sweep::all, glass).configurations)
    EXPECT_NE(has_at_least(all, point), is_left_out(point)) << describe(point);
}

TEST(CandidateConfigurations, SayTheirParts) {
  SweepScene scene = glass;
  scene.smallest_angle_deg = 0.1;
  const auto all = candidate_configurations(scene, {});
  const Configuration usual{{"translucency", "hybrid"}, {"layers", "4"}, {"cache-rate", "full"}, {"shadows", "exact"}};
  ASSERT_EQ(all.front().configuration, usual);
  const auto with = [&](const std::string& option, const std::string& value) {
    Configuration wanted = usual;
    wanted[option] = value;
    const auto at = std::find_if(all.begin(), all.end(), [&](const auto& c) { return c.configuration == wanted; });
    EXPECT_NE(at, all.end()) << option;
    return at == all.end() ? all.front() : *at;
  };
  for (const char* option : {"shadows", "cull-angle"}) {
    const CandidateConfiguration other = with(option, option == std::string("shadows") ? "map" : "2");
    EXPECT_EQ(other.drawing, all.front().drawing) << option;
    EXPECT_NE(other.shadows, all.front().shadows) << option;
  }
  for (const char* option : {"cache-rate", "denoise"}) {
    const CandidateConfiguration other = with(option, option == std::string("denoise") ? "off" : "quarter");
    EXPECT_NE(other.drawing, all.front().drawing) << option;
    EXPECT_EQ(other.shadows, all.front().shadows) << option;
  }
}

TEST(CandidateConfigurations, LeaveGivenOptionsAlone) {
  const auto fixed = candidate_configurations(glass, {{"layers", "3"}, {"shadows", "off"}});
  for (const CandidateConfiguration& c : fixed)
    EXPECT_FALSE(c.configuration.contains("layers") || c.configuration.contains("shadows"));
  EXPECT_TRUE(has(fixed, {{"translucency", "hybrid"}, {"cache-rate", "quarter"}}));
  for (const CandidateConfiguration& c : candidate_configurations(glass, {{"translucency", "raytraced"}}))
    EXPECT_FALSE(c.configuration.contains("translucency"));
}

}  // namespace
}  // namespace sideray::lab
