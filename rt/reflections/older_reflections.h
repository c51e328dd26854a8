// The history of reflections, for tiles that have no turn: filtered reflections are reprojected with their surface, and
// the least recently traced tile comes first in the next frame. One object a sequence. One thread calls it, except
// functions of one tile, which several threads may call for different tiles.
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
  // History expires after this many frames: mirror images move otherwise than their surfaces.
  static constexpr uint8_t oldest = 60;
  static constexpr uint8_t no_answer = 255;  // in place of an age

  // Begins a frame that may have no time for all tiles, and whose image is to be filled. A frame that does not
  // continue, and other lights, surroundings, materials or options, reset the history.
  void begin(const ReflectionRequest& request, TracedScene& scene, ReflectionImage& image);
  // Resets the history.
  void forget() { known_ = false; }

  // In which frame each tile had its turn, 0 = never.
  const std::vector<uint32_t>& turns() const { return turns_; }
  // Returns of each pixel what OlderMasks::answers() does.
  std::vector<uint8_t> answers() const;
  // Call when a tile is traced: it was cleared before.
  void traced(size_t tile);
  // Fills a tile with its history, empty where there is none; counts its pixels that mirror anything.
  void leave(const ReflectionRequest& request, size_t tile, ReflectionImage& image, Counters& counters);
  // Call after one of these was called for each tile.
  void end() { known_ = true; }

 private:
  bool follows(const ReflectionRequest& request, const model::Snapshot& committed) const;
  void empty(size_t tile, ReflectionImage& image);
  template <typename Work>
  void for_rows(size_t tile, const Work& work) const;

  bool known_ = false, moves_ = false;  // the last frame's image; it is moved into this one
  uint32_t width_ = 0, height_ = 0, number_ = 0;
  float max_roughness_ = 0.0f;
  bool shadows_ = false, light_bounces_ = false, denoise_ = false;
  std::shared_ptr<const model::Snapshot> committed_;
  PixelTrail own_trail_;
  PixelTrail* trail_ = &own_trail_;  // of the frame
  uint64_t step_ = 0;                // of the trail in the last frame
  std::vector<uint16_t> then_;  // the image of the previous frame
  std::vector<uint8_t> empty_, empty_then_;  // of each tile of both: it holds nothing
  std::vector<uint8_t> ages_, ages_then_;
  std::vector<uint32_t> turns_;
};

}  // namespace sideray::rt
