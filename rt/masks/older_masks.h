// The history of masks, for tiles that have no turn under a deadline: filtered masks are reprojected with their
// surface, and the least recently traced tile comes first in the next frame. Most tiles of most masks are all lit or
// all dark and are flagged as such, so that they are neither copied nor moved pixel by pixel. One object a sequence.
// One thread calls it, except functions of one tile, which several threads may call for different tiles.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/counters.h"
#include "rt/base/pixels.h"
#include "rt/history/pixel_trail.h"
#include "rt/masks/coarse_sky.h"
#include "rt/masks/mask_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

class OlderMasks {
 public:
  // The masks of lights, and those of the sky, are traced one after the other.
  enum Part { of_lights, of_sky, part_count };
  // History expires after this many commits of the scene; frames without a commit do not count.
  static constexpr uint8_t oldest = 120;
  static constexpr uint8_t no_answer = 255;  // in place of an age

  // Begins a frame with a request under a deadline. A frame that does not continue, other lights, options or another
  // size reset the history. `masks`: those of the previous frame.
  void begin(const MaskRequest& request, TracedScene& scene, const OcclusionMasks& masks);
  // Returns the depths along the camera's axis of the frame that has begun, as fill_depths() does.
  const std::vector<float>& depths() const { return trail_->depths(); }
  // Resets the history.
  void forget() {
    known_ = {};
    complete_ = false;
  }

  // In which frame each tile had its turn, 0 = never.
  const std::vector<uint32_t>& turns(Part part) const { return parts_[part].turns; }
  // Call when a tile's masks are traced.
  void traced(const MaskRequest& request, Part part, size_t tile);
  // Returns for each pixel of the frame that has ended 0 where its masks were traced in it, 1 and their age where they are
  // earlier ones, or no_answer.
  std::vector<uint8_t> answers(Part part) const;
  // Returns whether a part's masks have history.
  bool knows(Part part) const { return moves_[part]; }
  // Returns whether most pixels of a tile had no mask of the sky in the previous frame. Samples are to be written
  // before the tile is left.
  bool lacks_sky(size_t tile) const { return lacks_sky_[tile] != 0; }
  CoarseSky& coarse_sky() { return coarse_sky_; }
  // Fills a tile's masks with their history, reprojected; pixels without history are lit and open, the sky has its
  // samples. Counts the tile's pixels.
  void leave(const MaskRequest& request, Part part, size_t tile, OcclusionMasks& masks, Counters& counters);
  // Call after one of these was called for every tile of a part.
  void end(Part part);
  // Call when the frame's masks are filtered.
  void end_frame(const MaskRequest& request, const OcclusionMasks& masks, Executor& executor);
  // Sets for each pixel which of the frame's masks have an answer (OcclusionMasks::Answer); empty if all have.
  void tell_answers(const MaskRequest& request, Executor& executor, OcclusionMasks& masks) const;
  // Call when every mask of the position is there, and filtered as a whole: it stays what it is until the next one
  // begins.
  void complete();
  // Call when what new_tiles() said is filtered.
  void filtered();
  bool is_complete() const { return complete_; }
  // Says which of the filters' tiles were traced in this frame, or never filtered since, row by row.
  std::vector<uint8_t> new_tiles(const OcclusionMasks& masks, Part part) const;
  // Returns whether half of them or more were, of each part that ended.
  bool most_are_new() const;

 private:
  // What a plane of masks holds in a tile.
  enum Shade : uint8_t { all_dark = 0, mixed = 1, all_lit = 255 };
  struct Kept {
    std::vector<Shade> shades[2];  // of each plane's tiles, in this frame and the one before
    std::vector<uint8_t> then;     // where the view has moved, the mixed tiles of the previous frame, layer-major
    std::vector<uint8_t> ages[2];  // of this frame's pixels and of those before, or no_answer
    std::vector<uint32_t> turns;
    std::vector<uint8_t> unfiltered;  // of each tile: its masks are as they were traced
    bool ended = false;
  };
  // Pixels of a tile, row by row: the age of their history.
  struct Ages {
    std::array<std::array<uint8_t, frame_tile_size>, frame_tile_size> of;
    bool all_known, none_known;
  };

  bool follows(const MaskRequest& request, const model::Snapshot& snapshot) const;
  void fit(const MaskRequest& request);
  void keep_mixed(const MaskRequest& request, Part part, const OcclusionMasks& masks, Executor& executor);
  void look_back(Part part, size_t tile, Ages& found) const;
  Shade shade_there(Part part, uint32_t plane, size_t tile, const Ages& found) const;
  bool were_mixed(Part part, uint32_t plane, size_t tile) const;
  void take_samples(const MaskRequest& request, size_t tile, Ages& found, OcclusionMasks& masks);
  void show(const MaskRequest& request, Part part, size_t tile, const Ages& found, OcclusionMasks& masks);

  std::array<bool, part_count> known_{};  // the masks of the last frame
  std::array<bool, part_count> moves_{};  // ... are moved into this one
  Kept parts_[part_count];
  uint32_t now_ = 0;                        // which of a part's two buffers is this frame's
  MaskRequest request_;                     // of the last frame; pointers in it are not followed
  std::vector<model::Light> lights_;
  std::shared_ptr<const model::Environment> environment_;
  uint64_t revision_ = 0, opaque_revision_ = 0;
  uint32_t number_ = 0;  // of the frame
  bool changed_ = false, complete_ = false;
  PixelTrail own_trail_;
  PixelTrail* trail_ = &own_trail_;  // of the frame
  uint64_t step_ = 0;                // of the trail in the last frame
  CoarseSky coarse_sky_;
  std::vector<uint8_t> lacks_sky_;
};

}  // namespace sideray::rt
