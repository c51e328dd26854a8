// Where a frame stands in its sequence. Any thread.
#pragma once

namespace sideray::rt {

// What a frame is in its sequence, for temporal rates.
enum class SequenceStep {
  first,  // nothing before it counts
  next,   // it follows the last frame of its history
  again   // it is the last frame once more, or another sample position of it
};

}  // namespace sideray::rt
