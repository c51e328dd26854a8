// Holds the history of reflections, for skipped tiles: filtered reflections are reprojected with their surface, and the
// least recently traced tile comes first in the next frame. One object a sequence. One thread calls it, but several
// threads may call the functions of one tile for different tiles.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/counters.h"
#include "rt/history/pixel_trail.h"
#include "rt/reflections/reflection_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

class OlderReflections {
 public:
  // History expires after this many frames in which the eye or the scene moved, because reflections move differently
  // from their surfaces.
  static constexpr uint8_t oldest = 60;
  static constexpr uint8_t no_answer = 255;  // instead of an age

  // Begins a frame that may skip tiles, and whose image is to be filled. A frame that does not continue the sequence
  // resets the history, and so do other lights, environments, materials or options.
  void begin(const ReflectionRequest& request, TracedScene& scene, ReflectionImage& image);
  // Resets the history.
  void forget() { known_ = false; }

  // Returns the frame that last traced each tile, 0 = none.
  const std::vector<uint32_t>& turns() const { return turns_; }
  // Returns the age of each pixel's reflection, encoded as by OlderMasks::answers().
  std::vector<uint8_t> answers() const;
  // Notes that a tile, which was cleared before, was traced.
  void traced(size_t tile);
  // Fills a skipped tile with its history, empty without one; counts its reflecting pixels.
  void leave(const ReflectionRequest& request, size_t tile, ReflectionImage& image, Counters& counters);
  // Ends the frame, after traced() or leave() was called for each tile.
  void end() { known_ = true; }

 private:
  bool follows(const ReflectionRequest& request, const model::Snapshot& committed) const;
  bool has_past(size_t tile) const;
  void empty_tile(size_t tile, ReflectionImage& image);
  // Removes the reflections of pixels of a row.
  void empty(size_t first, uint32_t count, ReflectionImage& image);
  template <typename Work>
  void for_rows(size_t tile, const Work& work) const;

  bool known_ = false, moves_ = false;  // the last frame's image is complete; it is reprojected into this one
  uint32_t width_ = 0, height_ = 0, number_ = 0;
  uint8_t step_of_age_ = 0;  // by which history ages in this frame
  float max_roughness_ = 0.0f;
  bool shadows_ = false, light_bounces_ = false, denoise_ = false;
  std::shared_ptr<const model::Snapshot> committed_;
  PixelTrail own_trail_;
  PixelTrail* trail_ = &own_trail_;  // the frame's
  uint64_t step_ = 0;                // the trail's step() in the last frame
  std::vector<uint16_t> then_;  // the image of the previous frame
  std::vector<uint8_t> empty_, empty_then_;  // by tile: holds no reflection in this frame, and in the previous one
  std::vector<uint8_t> ages_, ages_then_;
  std::vector<uint32_t> turns_;
};

}  // namespace sideray::rt
