// Says where a frame stands in its sequence. Any thread may use it.
#pragma once

namespace sideray::rt {

// Says what a frame is in its sequence.
enum class SequenceStep {
  first,  // earlier frames it do not count
  next,   // it follows the last frame of its history
  again   // it redraws the last frame, or draws another sample position of it
};

}  // namespace sideray::rt
