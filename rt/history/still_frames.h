// Decides whether a frame of a sequence equals the last one: then its answers have the same bits, and nothing has to be
// traced, filtered or uploaded. Inputs are compared, not announced (docs/adr/0046-still-views.md). One object a view
// and job; one thread calls it.
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

// All on which a job's answers depend, besides the scene and the pictures that it reads.
struct FrameKey {
  std::vector<std::byte> inputs;  // bytes that all count, of what is asked for
  TraceView view{};
  uint32_t width = 0, height = 0;
  DepthFormat format{};
  uint32_t mask = 0, stencil_bits = 0, seed = 0;
  bool shadows = false, bounces = false;
  float subpixel = 0.0f;
};

class StillFrames {
 public:
  using Hashes = std::array<PictureHash, 2>;
  // Takes the next frame, and returns whether it equals the last one. `hash_pictures` is called only if everything else
  // is equal, so that a moving view hashes nothing: the third equal frame is the first that is recognized. Wind,
  // sprites and a host's shader never stand still; a frame that does not continue, or redraws the last one, is always
  // traced. `committed`: without poses.
  bool begin(FrameKey key, SequenceStep step, std::shared_ptr<const model::Snapshot> committed,
             const std::function<Hashes()>& hash_pictures);
  // Takes the counters of the frame. `whole`: every answer is there.
  void end(const Counters& counters, bool whole);
  // The answers are no longer those of the last frame.
  void forget() { is_whole_ = false; }

  // Returns the counters of a frame that equals the last one: no ray.
  Counters counters() const;

 private:
  FrameKey key_;
  std::optional<Hashes> hashes_;
  std::shared_ptr<const model::Snapshot> committed_;
  Counters counters_;
  bool is_whole_ = false;
};

// Returns the bytes of a struct up to the end of its last member: it has padding only behind that.
template <typename T, typename Last>
std::vector<std::byte> bytes_through(Last T::*last, const T& inputs) {
  const auto* begin = reinterpret_cast<const std::byte*>(&inputs);
  return {begin, reinterpret_cast<const std::byte*>(&(inputs.*last) + 1)};
}

}  // namespace sideray::rt
