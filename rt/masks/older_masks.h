// Holds the history of masks, for tiles that a deadline skips: filtered masks are reprojected with their surface, and
// the least recently traced tile comes first in the next frame. Most tiles of most masks are all lit or all dark; they
// are flagged as such, and neither copied nor moved pixel by pixel. One object a sequence. One thread calls it, but
// several threads may call the functions of one tile for different tiles.
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
  // Masks of lights and of the sky are traced one after the other.
  enum Part { of_lights, of_sky, part_count };
  // History expires after this many commits of the scene; frames without a commit do not count.
  static constexpr uint8_t oldest = 120;
  static constexpr uint8_t no_answer = 255;  // instead of an age

  // Begins a frame with a request under a deadline. A frame that does not continue the sequence resets the history, and
  // so do other lights, options or sizes. `masks` must be those of the previous frame.
  void begin(const MaskRequest& request, TracedScene& scene, const OcclusionMasks& masks);
  // Returns the current frame's depths along the camera's axis, as fill_depths() does.
  const std::vector<float>& depths() const { return trail_->depths(); }
  // Resets the history.
  void forget() {
    known_ = {};
    complete_ = false;
  }

  // Returns the frame that last traced each tile, 0 = none.
  const std::vector<uint32_t>& turns(Part part) const { return parts_[part].turns; }
  // Notes that a tile's masks were traced.
  void traced(const MaskRequest& request, Part part, size_t tile);
  // Returns for each pixel of the last frame 0 if its masks were traced in it, 1 + their age if they are older, or
  // no_answer.
  std::vector<uint8_t> answers(Part part) const;
  // Returns whether a part's masks have history.
  bool knows(Part part) const { return moves_[part]; }
  // Returns whether most pixels of a tile had no sky mask in the previous frame. Such a tile's samples must be written
  // before leave().
  bool lacks_sky(size_t tile) const { return lacks_sky_[tile] != 0; }
  CoarseSky& coarse_sky() { return coarse_sky_; }
  // Fills a skipped tile's masks with reprojected history. Pixels without history become lit and open; the sky uses its
  // samples. Counts the tile's pixels.
  void leave(const MaskRequest& request, Part part, size_t tile, OcclusionMasks& masks, Counters& counters);
  // Returns whether a tile of a layer's tints shows history that is known to be white.
  bool is_white(const MaskRequest& request, const OcclusionMasks& masks, uint32_t layer, size_t tile) const;
  // Ends a part, after traced() or leave() was called for each of its tiles.
  void end(Part part);
  // Ends the frame, after its masks are filtered.
  void end_frame(const MaskRequest& request, const OcclusionMasks& masks, Executor& executor);
  // Sets which masks of each pixel have an answer (OcclusionMasks::Answer); empty if all have.
  void tell_answers(const MaskRequest& request, Executor& executor, OcclusionMasks& masks) const;
  // Notes that every mask of the position is traced and filtered as a whole, so that it stays until the next position.
  void complete();
  // Notes that the tiles of new_tiles() are filtered.
  void filtered();
  bool is_complete() const { return complete_; }
  // Returns for each filter tile, row by row, whether it was traced in this frame or never filtered since it was.
  std::vector<uint8_t> new_tiles(const OcclusionMasks& masks, Part part) const;
  // Returns whether at least half of the tiles were traced in this frame, for each part that has ended.
  bool most_are_new() const;

 private:
  // Says what a plane of masks holds in a tile.
  enum Shade : uint8_t { all_dark = 0, mixed = 1, all_lit = 255 };
  struct Kept {
    std::vector<Shade> shades[2];  // of each plane's tiles, in this frame and the previous one
    std::vector<uint8_t> then;     // mixed tiles and those beside them of the previous frame if the view has moved,
                                   // layer-major
    std::vector<uint8_t> copied;   // of each plane's tiles: it is in `then`
    std::vector<uint8_t> ages[2];  // of the pixels of this frame and the previous one, or no_answer
    std::vector<uint8_t> tile_ages[2];  // what all of a tile's pixels have in `ages`, or various_ages
    std::vector<uint32_t> turns;
    std::vector<uint8_t> unfiltered;  // by tile: its masks are not filtered yet
    bool ended = false;
  };
  // Holds the ages of the history of a tile's pixels, row by row.
  struct Ages {
    std::array<std::array<uint8_t, frame_tile_size>, frame_tile_size> of;
    uint8_t common;  // as tile_ages
    bool all_known, none_known;
    void fill_unknown();
  };
  static constexpr uint8_t various_ages = 254;

  bool follows(const MaskRequest& request, const model::Snapshot& snapshot) const;
  void fit(const MaskRequest& request);
  void keep_mixed(const MaskRequest& request, Part part, const OcclusionMasks& masks, Executor& executor);
  static bool has_mixed_around(const Shade* shades, glm::uvec2 tile, const MaskRequest& request);
  uint8_t common_age_there(Part part, size_t tile) const;
  void look_back(Part part, size_t tile, Ages& found) const;
  Shade shade_there(Part part, uint32_t plane, size_t tile, const Ages& found) const;
  bool were_copied(Part part, uint32_t plane, size_t tile) const;
  void take_samples(const MaskRequest& request, size_t tile, Ages& found, OcclusionMasks& masks);
  void show(const MaskRequest& request, Part part, size_t tile, const Ages& found, OcclusionMasks& masks);

  std::array<bool, part_count> known_{};  // the last frame's masks are complete
  std::array<bool, part_count> moves_{};  // they are reprojected into this frame
  Kept parts_[part_count];
  uint32_t now_ = 0;                        // index of this frame's buffer in each part
  MaskRequest request_;                     // of the last frame; its pointers are not followed
  std::vector<model::Light> lights_;
  std::shared_ptr<const model::Environment> environment_;
  uint64_t revision_ = 0, opaque_revision_ = 0;
  uint32_t number_ = 0;  // the frame's number
  bool changed_ = false, complete_ = false;
  PixelTrail own_trail_;
  PixelTrail* trail_ = &own_trail_;  // the frame's
  uint64_t step_ = 0;                // the trail's step() in the last frame
  CoarseSky coarse_sky_;
  std::vector<uint8_t> lacks_sky_;
};

}  // namespace sideray::rt
