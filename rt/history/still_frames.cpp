#include "rt/history/still_frames.h"

#include <utility>

#include "rt/scene/scene_difference.h"

namespace sideray::rt {
namespace {

bool same_view(const TraceView& a, const TraceView& b) {
  return a.clip_from_local == b.clip_from_local && a.local_from_clip == b.local_from_clip &&
         a.reversed_depth == b.reversed_depth && a.zero_to_one_depth == b.zero_to_one_depth;
}

bool same_key(const FrameKey& a, const FrameKey& b) {
  return a.inputs == b.inputs && same_view(a.view, b.view) && a.width == b.width && a.height == b.height &&
         a.format == b.format && a.mask == b.mask && a.stencil_bits == b.stencil_bits && a.seed == b.seed &&
         a.position == b.position && a.shadows == b.shadows && a.bounces == b.bounces && a.subpixel == b.subpixel;
}

bool may_stand_still(const model::Snapshot& snapshot) {
  return snapshot.winds.empty() && snapshot.particles.empty() && !snapshot.shader.shade;
}

}  // namespace

bool StillFrames::begin(FrameKey key, SequenceStep step, std::shared_ptr<const model::Snapshot> committed,
                        const std::function<Hashes()>& hash_pictures) {
  const bool may_be_last = is_whole_ && step == SequenceStep::next && same_key(key_, key) && may_stand_still(*committed) &&
                           are_equal(*committed_, *committed);
  std::optional<Hashes> hashes;
  if (may_be_last) hashes = hash_pictures();
  const bool is_last = may_be_last && hashes_ == hashes;
  is_whole_ = is_last;
  hashes_ = hashes;
  key_ = std::move(key);
  committed_ = std::move(committed);
  return is_last;
}

void StillFrames::end(const Counters& counters, bool whole) {
  counters_ = counters;
  is_whole_ = whole;
}

Counters StillFrames::counters() const {
  Counters kept;
  kept.pixels_total = counters_.pixels_total;
  kept.pixels_masked = counters_.pixels_masked;
  kept.layers_requested = counters_.layers_requested;
  kept.layers_found = counters_.layers_found;
  kept.layers_refracted = counters_.layers_refracted;
  kept.traversals_wasted = counters_.traversals_wasted;
  return kept;
}

}  // namespace sideray::rt
