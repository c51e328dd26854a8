// Tests what makes a frame another one than the last.
#include "rt/history/still_frames.h"

#include <gtest/gtest.h>

#include <functional>

namespace sideray::rt::still_frames_test {
namespace {

class FramesAtRest : public testing::Test {
 protected:
  bool frame(SequenceStep step = SequenceStep::next) {
    const bool is_last = still_.begin(key_, step, std::make_shared<const model::Snapshot>(snapshot_), [&] {
      ++hashed_;
      return hashes_;
    });
    if (!is_last) still_.end({}, true);
    return is_last;
  }
  // Begins a sequence until its frames are known as equal.
  void rest() {
    EXPECT_FALSE(frame(SequenceStep::first));
    EXPECT_FALSE(frame());
    ASSERT_TRUE(frame());
  }

  StillFrames still_;
  FrameKey key_{.inputs = {std::byte{1}}, .width = 4, .height = 3, .format = DepthFormat::d24};
  StillFrames::Hashes hashes_{};
  model::Snapshot snapshot_;
  int hashed_ = 0;
};

TEST_F(FramesAtRest, are_known_from_the_third_on) {
  rest();
  EXPECT_TRUE(frame());
}

TEST_F(FramesAtRest, end_with_every_input) {
  const std::vector<std::pair<const char*, std::function<void()>>> changes{
      {"inputs", [&] { key_.inputs[0] = std::byte{2}; }},
      {"clip from local", [&] { key_.view.clip_from_local[3][0] += 1e-9; }},
      {"local from clip", [&] { key_.view.local_from_clip[3][0] += 1e-9; }},
      {"reversed depth", [&] { key_.view.reversed_depth = true; }},
      {"range of depth", [&] { key_.view.zero_to_one_depth = true; }},
      {"width", [&] { ++key_.width; }},
      {"height", [&] { ++key_.height; }},
      {"format", [&] { key_.format = DepthFormat::d16; }},
      {"mask", [&] { key_.mask = 1; }},
      {"stencil bits", [&] { key_.stencil_bits = 1; }},
      {"seed", [&] { key_.seed = 1; }},
      {"position", [&] { key_.position = 1; }},
      {"shadows", [&] { key_.shadows = true; }},
      {"bounces", [&] { key_.bounces = true; }},
      {"snapping of vertices", [&] { key_.subpixel = 0.5f; }},
      {"depth", [&] { hashes_[0][2] = 1; }},
      {"second picture", [&] { hashes_[1][3] = 1; }},
      {"scene", [&] { snapshot_.lights.emplace_back(); }}};
  for (const auto& [what, change] : changes) {
    rest();
    change();
    EXPECT_FALSE(frame()) << what;
  }
}

TEST_F(FramesAtRest, end_with_a_cut_or_a_frame_drawn_again) {
  for (const SequenceStep step : {SequenceStep::first, SequenceStep::again}) {
    rest();
    EXPECT_FALSE(frame(step));
  }
}

TEST_F(FramesAtRest, end_where_answers_are_missing_or_replaced) {
  rest();
  still_.forget();
  EXPECT_FALSE(frame());
  rest();
  still_.end({}, false);
  EXPECT_FALSE(frame());
}

// A frame that was begun but did not end has no answers to repeat.
TEST_F(FramesAtRest, follow_no_frame_that_did_not_end) {
  rest();
  key_.seed = 1;
  const auto begin = [&] {
    return still_.begin(key_, SequenceStep::next, std::make_shared<const model::Snapshot>(snapshot_),
                        [&] { return hashes_; });
  };
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(begin());
}

TEST_F(FramesAtRest, keep_the_counts_of_the_picture_and_none_of_the_work) {
  Counters counters;
  counters.pixels_total = 12, counters.pixels_masked = 5, counters.layers_requested = 9, counters.layers_found = 7;
  counters.layers_refracted = 3, counters.traversals_wasted = 2, counters.rays_shadow = 100;
  still_.end(counters, true);
  const Counters kept = still_.counters();
  EXPECT_EQ(kept.pixels_total, 12u);
  EXPECT_EQ(kept.pixels_masked, 5u);
  EXPECT_EQ(kept.layers_requested, 9u);
  EXPECT_EQ(kept.layers_found, 7u);
  EXPECT_EQ(kept.layers_refracted, 3u);
  EXPECT_EQ(kept.traversals_wasted, 2u);
  EXPECT_EQ(kept.rays_shadow, 0u);
}

// Wind, sprites and a host's shader change pictures without a commit.
TEST_F(FramesAtRest, are_none_where_something_moves_by_itself) {
  const auto never = [&](const char* what) {
    frame(SequenceStep::first);
    for (int i = 0; i < 4; ++i) EXPECT_FALSE(frame()) << what;
    snapshot_ = {};
  };
  snapshot_.winds.emplace_back();
  never("wind");
  snapshot_.particles.emplace_back();
  never("particles");
  snapshot_.shader.shade = [](auto...) {};
  never("shader");
  rest();
}

TEST_F(FramesAtRest, hash_nothing_while_the_view_moves) {
  frame(SequenceStep::first);
  for (int i = 0; i < 4; ++i) {
    key_.view.clip_from_local[3][0] += 1.0;
    frame();
  }
  EXPECT_EQ(hashed_, 0);
}

}  // namespace
}  // namespace sideray::rt::still_frames_test
