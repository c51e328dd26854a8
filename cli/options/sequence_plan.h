// Plans which frames of a sequence a run draws: its block, and frames before one that only warm up temporal methods.
// Only handles numbers. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sideray::cli {

struct Shard {
  uint32_t index = 0, count = 1;  // index < count
};

struct Block {
  uint32_t begin = 0, end = 0;  // frames from `begin` on, without `end`
};

// Returns a shard's block. Blocks of all shards are adjacent, cover each of `frames` frames from `first` on once, and
// differ by at most one in size; with more shards than frames some are empty.
Block block_of(uint32_t first, uint32_t frames, Shard shard);

struct Step {
  uint32_t frame = 0;
  bool is_wanted = false;  // otherwise it only warms up and is discarded
  bool continues = false;  // the previous step is the previous frame
};

// Returns the frames to draw in ascending order: `wanted` (ascending, distinct), and before each the `warm_up` frames
// before it that are not wanted themselves, none before `first`. If `warm_up` >= `period`, warming up begins a multiple
// of `period` frames after `first`, so that what repeats is in step with a run from `first` on.
std::vector<Step> plan_steps(uint32_t first, std::span<const uint32_t> wanted, uint32_t warm_up, uint32_t period = 1);

}  // namespace sideray::cli
