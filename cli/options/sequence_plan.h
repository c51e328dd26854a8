// Which frames of a sequence a run draws: its block, and those before a frame that only warm temporal methods up.
// Knows numbers alone. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sideray::cli {

struct Shard {
  uint32_t index = 0, count = 1;  // index < count
};

struct Block {
  uint32_t begin = 0, end = 0;  // of frames; end is not among them
};

// The blocks of all shards stand side by side, cover each of `frames` frames from `first` on once, and differ by at
// most one in size; with more shards than frames some are empty.
Block block_of(uint32_t first, uint32_t frames, Shard shard);

struct Step {
  uint32_t frame = 0;
  bool is_wanted = false;  // otherwise it warms up, and nothing of it is kept
  bool continues = false;  // the step before is the frame before
};

// The frames to draw, ascending: `wanted` (ascending, none twice), and before each those of the `warm_up` frames before
// it that are not wanted themselves, none before `first`. What repeats after `period` frames is in step with a run from
// `first` on, where warming up is that long at all: it then begins a whole number of periods behind `first`.
std::vector<Step> plan_steps(uint32_t first, std::span<const uint32_t> wanted, uint32_t warm_up, uint32_t period = 1);

}  // namespace sideray::cli
