// Tests still views through the public interface with its defaults: they converge to the picture of many camera
// positions, and then cost nothing until something changes.
#include <sideray/diagnostics.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "frame/views/view.h"

namespace sideray::tests::still_view_test {
namespace {

constexpr uint32_t width = 64, height = 36, positions = still_positions;

View view_of(const char* scene) {
  return {scenes::generate(scene, {}), width, height};
}

double difference(const Shown& a, const Shown& b) {
  double sum = 0;
  for (size_t i = 0; i < a.colors.size(); ++i) sum += std::abs(double{a.colors[i]} - double{b.colors[i]});
  return sum / static_cast<double>(a.colors.size());
}

TEST(StillView, BecomesThePictureOfItsPositionsAndThenCostsNothing) {
  View view = view_of("solids");
  const uint32_t seed = view.options.picture.seed;
  const Shown first = view.draw();
  EXPECT_EQ(first.stats.positions, 1u);
  const Shown whole = view.alone(seed);
  ASSERT_EQ(whole.stats.positions, positions);
  std::vector<double> errors{difference(first, whole)};
  for (uint32_t n = 1; n < positions; ++n) {
    const Shown shown = view.draw();
    ASSERT_EQ(shown.stats.positions, n);
    ASSERT_GT(shown.rays(), 0u) << n;
    errors.push_back(difference(shown, whole));
  }
  EXPECT_LT(errors[4], 0.7 * errors[0]);
  EXPECT_LT(errors[16], 0.7 * errors[4]);
  EXPECT_LT(errors[48], 0.7 * errors[16]);
  const Shown all = view.draw();
  EXPECT_EQ(all.stats.positions, positions);
  EXPECT_EQ(all.colors, whole.colors);
  for (int i = 0; i < 3; ++i) {
    const Shown kept = view.draw();
    EXPECT_EQ(kept.colors, whole.colors);
    EXPECT_EQ(kept.rays(), 0u);
    EXPECT_EQ(kept.stats.bytes_upload + kept.stats.bytes_readback, 0u);
    EXPECT_EQ(kept.stats.positions, positions);
  }
}

TEST(StillView, BeginsAnewWhereSomethingChanges) {
  for (const bool done : {false, true}) {
    View view = view_of("solids");
    view.draw(done ? positions + 3 : 20);
    view.brighten_first_light();
    const uint32_t seed = view.options.picture.seed;
    const Shown changed = view.draw();
    EXPECT_EQ(changed.stats.positions, 1u);
    EXPECT_GT(changed.rays(), 0u);
    if (!done) {
      EXPECT_EQ(view.draw(positions).colors, view.alone(seed).colors);
    }
    view.step_aside();
    EXPECT_GT(view.draw().rays(), 0u);
  }
}

TEST(StillView, GoesOnWhereACommitChangesNothing) {
  View view = view_of("solids");
  view.draw();
  for (uint32_t n = 1; n <= positions; ++n) {
    view.commit();
    ASSERT_EQ(view.draw().stats.positions, n);
  }
  view.commit();
  EXPECT_EQ(view.draw().rays(), 0u);
}

// When a view begins to move again, its history is the converged picture, not the one from when it stopped.
TEST(StillView, LeavesItsPictureToTheAverage) {
  View still = view_of("solids"), hasty = view_of("solids");
  still.draw(positions + 1);
  hasty.draw(2);
  still.step_aside(), hasty.step_aside();
  const uint32_t seed = still.options.picture.seed;
  const Shown after = still.draw(), hastily = hasty.draw();
  const Shown whole = still.alone(seed);
  EXPECT_LT(difference(after, whole), 0.8 * difference(hastily, whole));
}

TEST(StillView, IsNoneWhereOptionsChangeOrNothingIsAveraged) {
  View view = view_of("solids");
  view.draw(3);
  view.options.picture.denoise = !view.options.picture.denoise;
  EXPECT_EQ(view.draw().stats.positions, 1u);
  EXPECT_EQ(view.draw().stats.positions, 1u);
  EXPECT_EQ(view.draw().stats.positions, 2u);
  view.options.picture.taa = 0;
  view.draw();
  EXPECT_EQ(view.draw().stats.positions, 1u);
  view.options.picture.taa = 1;
  view.options.picture.continues = 0;
  view.draw();
  view.options.picture.continues = 0;
  EXPECT_EQ(view.draw().stats.positions, 1u);
}

struct UnderBudget {
  Shown whole, done;
};

// Sets a budget of one piece of each job a frame. Each position takes as many frames as it needs, and pictures are
// complete meanwhile.
UnderBudget under_a_budget(View& view) {
  view.options.translucency->ray_reuse = 0.0f;  // who lends to whom depends on the pieces
  const uint32_t seed = view.options.picture.seed;
  const Shown whole = view.alone(seed);
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  view.options.picture.diagnostics = &diagnostics;
  diagnostics.budget_pieces = 2;
  const Shown first = view.draw();
  double error = difference(first, whole);
  const uint64_t most = whole.rays() / positions;
  uint64_t least = most;
  int frames = 0;
  for (uint64_t positions_then = 1; frames < 4000; ++frames) {
    const Shown shown = view.draw();
    if (shown.rays() == 0) break;
    least = std::min(least, shown.rays());
    EXPECT_GE(shown.stats.positions, positions_then);
    positions_then = shown.stats.positions;
    const double now = difference(shown, whole);
    EXPECT_LT(now, 1.5 * error) << "in frame " << frames;
    if (testing::Test::HasFailure()) break;
    error = std::min(error, now);
  }
  EXPECT_GT(frames, static_cast<int>(2 * positions));
  EXPECT_LT(2 * least, most);
  const Shown done = view.draw();
  EXPECT_EQ(done.stats.positions, positions);
  EXPECT_EQ(done.rays(), 0u);
  view.options.picture.diagnostics = nullptr;
  return {whole, done};
}

TEST(StillView, UnderABudgetBecomesTheSamePicture) {
  View view = view_of("solids");
  view.options.picture.ambient = SIDERAY_AMBIENT_AO;
  const UnderBudget drawn = under_a_budget(view);
  EXPECT_EQ(drawn.done.colors, drawn.whole.colors);
}

// Hits in a piece share bounced light in mirrors and glass, with fewer others than in a whole picture: there is more noise,
// but no more or less light.
TEST(StillView, UnderABudgetBecomesNearlyThatWhereLightBounces) {
  View view = view_of("solids");
  const uint32_t seed = view.options.picture.seed;
  const UnderBudget drawn = under_a_budget(view);
  const double noise = difference(view.alone(seed + 1), drawn.whole);
  EXPECT_GT(difference(drawn.done, drawn.whole), 0.0);
  EXPECT_LT(difference(drawn.done, drawn.whole), 1.5 * noise);
  const auto sum = [](const Shown& shown) { return std::accumulate(shown.colors.begin(), shown.colors.end(), 0.0); };
  EXPECT_NEAR(sum(drawn.done) / sum(drawn.whole), 1.0, 1e-3);
}

// Such layers are not kept between frames, so that under a budget no position would ever be complete.
TEST(StillView, UnderABudgetIsNoneWhereLayersAreNotKept) {
  for (const bool composited : {true, false}) {
    View view = view_of("solids");
    if (composited) view.options.translucency->method = SIDERAY_TRANSLUCENCY_RAYTRACED;
    else view.options.translucency->cache_rate = SIDERAY_RATE_CHECKERBOARD;
    sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
    view.options.picture.diagnostics = &diagnostics;
    diagnostics.budget_pieces = 2;
    std::vector<float> before = view.draw().colors;
    for (int frame = 0; frame < 4; ++frame) {
      const Shown shown = view.draw();
      EXPECT_NE(shown.colors, before) << composited << ' ' << frame;
      EXPECT_EQ(shown.stats.positions, 1u);
      before = shown.colors;
    }
  }
}

// A program that poses its scene in each frame has a still view too if nothing changes, also under a budget.
TEST(StillView, UnderABudgetGoesOnWhereSpritesStandStill) {
  View view = view_of("smoke");
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  view.options.picture.diagnostics = &diagnostics;
  diagnostics.budget_pieces = 4;
  uint32_t frames = 0;
  for (; frames < 60 && view.draw().stats.positions < 3; ++frames) view.commit();
  EXPECT_LT(frames, 60u);
}

// After a cut only traced pieces have answers: each frame shows more of them.
TEST(StillView, UnderABudgetShowsEachPieceAsItComes) {
  View view(scenes::generate("solids", {}), 192, 108);
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  view.options.picture.diagnostics = &diagnostics;
  diagnostics.budget_pieces = 2;
  std::vector<float> before = view.draw().colors;
  for (int frame = 0; frame < 4; ++frame) {
    const Shown shown = view.draw();
    EXPECT_NE(shown.colors, before) << frame;
    before = shown.colors;
  }
}

// A view does not restart where unchanged sprites are committed again.
TEST(StillView, GoesOnWhereSpritesStandStill) {
  View view = view_of("smoke");
  view.draw(2);
  view.commit();
  EXPECT_EQ(view.draw().stats.positions, 2u);
}

}  // namespace
}  // namespace sideray::tests::still_view_test
