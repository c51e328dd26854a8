// Decides whether a frame of a sequence equals the last one. Then its answers have the same bits, and nothing must be
// traced, filtered or uploaded. Inputs are compared; hosts announce nothing (docs/adr/0046-still-views.md). One object
// a view and job; one thread calls it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/counters.h"
#include "rt/base/sequence.h"
#include "rt/base/view.h"
#include "rt/history/picture_hash.h"

namespace sideray::rt {

// Holds everything that a job's answers depend on, besides the scene and the input pictures.
struct FrameKey {
  std::vector<std::byte> inputs;  // bytes of the requested options, without padding
  TraceView view{};
  uint32_t width = 0, height = 0;
  DepthFormat format{};
  uint32_t mask = 0, stencil_bits = 0, seed = 0, position = 0;
  bool shadows = false, bounces = false;
  float subpixel = 0.0f;
};

class StillFrames {
 public:
  using Hashes = std::array<PictureHash, 4>;
  // Begins the next frame, and returns whether it equals the last one. `hash_pictures` is called only if everything
  // else is equal, so that a moving view hashes nothing; therefore the third equal frame is the first that is
  // recognized. Scenes with wind, sprites or a host's shader never count as equal. A frame that does not continue the
  // sequence, or redraws the last one, is always traced. `committed`: without poses.
  bool begin(FrameKey key, SequenceStep step, std::shared_ptr<const model::Snapshot> committed,
             const std::function<Hashes()>& hash_pictures);
  // Stores the frame's counters. `whole`: every pixel has its answer.
  void end(const Counters& counters, bool whole);
  // Notes that the answers are no longer those of the last frame.
  void forget() { is_whole_ = false; }

  // Returns the counters of a frame that equals the last one: without rays.
  Counters counters() const;

 private:
  FrameKey key_;
  std::optional<Hashes> hashes_;
  std::shared_ptr<const model::Snapshot> committed_;
  Counters counters_;
  bool is_whole_ = false;
};

// Returns the bytes of a struct up to the end of its last member, behind which it may have padding, but not before.
template <typename T, typename Last>
std::vector<std::byte> bytes_through(Last T::*last, const T& inputs) {
  const auto* begin = reinterpret_cast<const std::byte*>(&inputs);
  return {begin, reinterpret_cast<const std::byte*>(&(inputs.*last) + 1)};
}

}  // namespace sideray::rt
