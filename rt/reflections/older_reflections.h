// What opaque surfaces mirrored in frames before, for tiles that have no time: it stays with the surface, wherever the camera
// has gone, as the filter has made it, and who was traced longest ago comes first in the next frame. One object a sequence.
// One thread calls it; what is said of a tile may be said of several tiles at a time.
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
  // An answer outlives so many frames: what mirrors show moves otherwise than they do.
  static constexpr uint8_t oldest = 60;
  static constexpr uint8_t no_answer = 255;  // in place of an age

  // Learns of a frame without time for all, whose image is to be filled. A frame that follows none, other lights,
  // surroundings, materials or options leave nothing.
  void begin(const ReflectionRequest& request, TracedScene& scene, ReflectionImage& image);
  // Nothing is known any longer.
  void forget() { known_ = false; }

  // In which frame each tile had its turn, 0 = never.
  const std::vector<uint32_t>& turns() const { return turns_; }
  // Learns that a tile is traced: it was emptied before.
  void traced(size_t tile);
  // Makes a tile what it was, empty where nothing is known; counts its pixels that mirror anything.
  void leave(const ReflectionRequest& request, size_t tile, ReflectionImage& image, Counters& counters);
  // Learns that one of these was said of each tile.
  void end() { known_ = true; }

 private:
  bool follows(const ReflectionRequest& request, const model::Snapshot& committed) const;
  template <typename Work>
  void for_rows(size_t tile, const Work& work) const;

  bool known_ = false, moves_ = false;  // the last frame's image; it is moved into this one
  uint32_t width_ = 0, height_ = 0, number_ = 0;
  float max_roughness_ = 0.0f;
  bool shadows_ = false, denoise_ = false;
  std::shared_ptr<const model::Snapshot> committed_;
  PixelTrail trail_;
  std::vector<uint16_t> then_;  // the image of the frame before
  std::vector<uint8_t> ages_, ages_then_;
  std::vector<uint32_t> turns_;
};

}  // namespace sideray::rt
