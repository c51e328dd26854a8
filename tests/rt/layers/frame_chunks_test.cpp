// Chunks of a frame's pixels, under a budget.
#include "rt/layers/frame_chunks.h"

#include <gtest/gtest.h>

#include <mutex>

#include "rt/tracer_scene.h"

namespace sideray::rt::frame_chunks_test {
namespace {

using namespace test;

// A frame without time for more traces the chunk that waited longest, in parts that several threads take, and no other
// chunk, even if its turn has some time.
TEST(FrameChunks, WithoutTimeTraceTheFirstInParts) {
  Executor executor(4);
  TestFrame frame(perspective({0, 0, 5}, {0, 0, 0}, 0.7, 1.0), 64, 64, 2);
  frame.get().work = {.deadline = Deadline::clock::now(), .least = std::chrono::seconds(1), .least_pieces = 1, .ends_in_time = true};
  const CacheRequest& request = frame.get();
  FrameChunks chunks;
  chunks.gather(request, selection_of(request), executor);
  const size_t uncut = chunks.count();
  const PixelRequest wanted = chunks.chunk(5).front();
  const auto last_turn = [&](std::span<const PixelRequest> pixels) {
    return pixels.front().x == wanted.x && pixels.front().y == wanted.y ? 1u : 2u;
  };
  chunks.take_turns(request, last_turn, executor);
  std::mutex mutex;
  size_t traced = 0, parts = 0, left = 0;
  bool has_wanted = false;
  Counters counters;
  chunks.run(
      request, executor,
      [&](size_t, std::span<const PixelRequest> pixels, uint32_t) {
        const std::lock_guard lock(mutex);
        traced += pixels.size(), ++parts;
        has_wanted = has_wanted || (pixels.front().x == wanted.x && pixels.front().y == wanted.y);
        return TraceEnd::complete;
      },
      [&](std::span<const PixelRequest> pixels, uint32_t) {
        const std::lock_guard lock(mutex);
        left += pixels.size();
        return pixels.size();
      },
      counters);
  EXPECT_EQ(traced, pixels_in_late_chunk);
  EXPECT_GT(parts, 4u);
  EXPECT_EQ(chunks.count(), uncut + parts - 1);
  EXPECT_TRUE(has_wanted);
  EXPECT_EQ(traced + left, size_t{64} * 64);
  EXPECT_EQ(counters.pixels_late, left);
}

}  // namespace
}  // namespace sideray::rt::frame_chunks_test
