// Compares blocks of a sequence and the steps of a run with their definitions, frame by frame.
#include "cli/options/sequence_plan.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sideray::cli_tests {
namespace {

using namespace cli;

TEST(SequencePlan, BlocksCoverEachFrameOnceAndDifferByOneAtMost) {
  for (const uint32_t first : {0u, 7u})
    for (uint32_t frames = 1; frames <= 40; ++frames)
      for (uint32_t count = 1; count <= 50; ++count) {
        uint32_t next = first;
        for (uint32_t index = 0; index < count; ++index) {
          const Block block = block_of(first, frames, {index, count});
          ASSERT_EQ(block.begin, next) << frames << " frames, shard " << index << "/" << count;
          ASSERT_GE(block.end, block.begin);
          const uint32_t size = block.end - block.begin;
          ASSERT_TRUE(size == frames / count || size == (frames + count - 1) / count) << size;
          next = block.end;
        }
        ASSERT_EQ(next, first + frames);
      }
}

TEST(SequencePlan, BlocksOfTheMostFramesDoNotOverflow) {
  const Block last = block_of(9000000, 1000000, {999999, 1000000});
  EXPECT_EQ(last.begin, 9999999u);
  EXPECT_EQ(last.end, 10000000u);
}

// A frame is drawn if it is wanted, or if a wanted one follows within `warm_up` frames.
TEST(SequencePlan, StepsAreTheWantedFramesAndThoseBeforeThem) {
  constexpr uint32_t first = 3, frames = 9;
  for (uint32_t warm_up : {0u, 1u, 2u, 4u, 16u, 1000000u})
    for (uint32_t bits = 0; bits < 1u << frames; ++bits) {
      const auto is_wanted = [&](uint32_t frame) { return (bits >> (frame - first) & 1u) != 0; };
      std::vector<uint32_t> wanted;
      for (uint32_t frame = first; frame < first + frames; ++frame)
        if (is_wanted(frame)) wanted.push_back(frame);
      const std::vector<Step> steps = plan_steps(first, wanted, warm_up);
      size_t at = 0;
      bool was_drawn = false;
      for (uint32_t frame = first; frame < first + frames; ++frame) {
        const bool is_drawn =
            std::any_of(wanted.begin(), wanted.end(), [&](uint32_t w) { return frame <= w && w - frame <= warm_up; });
        if (is_drawn) {
          ASSERT_LT(at, steps.size());
          ASSERT_EQ(steps[at].frame, frame);
          ASSERT_EQ(steps[at].is_wanted, is_wanted(frame));
          ASSERT_EQ(steps[at].continues, was_drawn);
          ++at;
        }
        was_drawn = is_drawn;
      }
      ASSERT_EQ(at, steps.size()) << "wanted " << bits << ", warm-up " << warm_up;
    }
}

// Patterns with a period of eight frames are the same in a warmed-up part as in the whole.
TEST(SequencePlan, WarmingUpKeepsStep) {
  constexpr uint32_t first = 3, period = 8;
  for (uint32_t warm_up : {8u, 11u, 16u, 100u})
    for (uint32_t frame = first; frame < first + 60; ++frame) {
      const std::vector<Step> steps = plan_steps(first, std::vector<uint32_t>{frame}, warm_up, period);
      EXPECT_EQ((steps.front().frame - first) % period, 0u);
      EXPECT_LE(frame - steps.front().frame, warm_up);
      EXPECT_GT(frame - steps.front().frame + period, std::min(warm_up, frame - first));
    }
  EXPECT_EQ(plan_steps(3, std::vector<uint32_t>{20}, 5, period).size(), 6u);
}

}  // namespace
}  // namespace sideray::cli_tests
