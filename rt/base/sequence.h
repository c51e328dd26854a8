// Says how a frame continues its sequence. Any thread may use it.
#pragma once

namespace sideray::rt {

// Relates a frame to the one before.
enum class SequenceStep {
  first,  // earlier frames do not count
  next,   // follows the last frame of its history
  again   // redraws the last frame, or draws another sample position of it
};

}  // namespace sideray::rt
