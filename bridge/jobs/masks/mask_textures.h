// Holds the textures of a frame's shadow and ambient occlusion masks. GL thread.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "bridge/transport/texture_upload.h"
#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "rt/masks/mask_request.h"
#include "rt/reach/wanted_tiles.h"

namespace sideray::bridge {

class MaskTextures {
 public:
  // Says which masks the textures hold already: those of lights, by layer, and that of the sky, behind them.
  using Held = std::function<bool(uint32_t layer)>;
  // Uploads the masks that are not held, and all where the textures are new. Skips tiles that are not `wanted`; null:
  // all are. Returns the bytes moved. Needs guards over the pixel transfer state and the active unit's textures.
  uint64_t upload(const gl::Functions& gl, const rt::OcclusionMasks& masks, const Held& held,
                  const rt::WantedTiles* wanted, const UploadWay& way);
  // Does the same as in CacheTextures.
  void prepare(const gl::Functions& gl, const rt::OcclusionMasks& masks);
  void abandon();
  uint64_t bytes() const {
    return uint64_t{now_.width} * now_.height *
           (now_.layers + 3 * now_.tints + (now_.ambient ? 1u : 0u) + (now_.depth ? 4u : 0u) + (now_.answers ? 1u : 0u));
  }
  uint32_t shadow() const { return now_.shadow.id(); }    // 2D array, or 0
  uint32_t ambient() const { return now_.ambient.id(); }  // 2D, or 0
  uint32_t tint() const { return now_.tint.id(); }        // 2D array, or 0
  uint32_t depth() const { return now_.depth.id(); }      // 2D, or 0
  uint32_t answers() const { return now_.answers.id(); }  // 2D, or 0; of a frame in which some answers were missing

 private:
  struct Storage {
    gl::Texture shadow, ambient, tint, depth, answers;
    uint32_t width = 0, height = 0, layers = 0, tints = 0;
    std::vector<Rectangle> tinted;  // of each place: no tint lies outside
    bool fits(const rt::OcclusionMasks& masks) const;
    void abandon();
  };
  Storage now_, next_;
  TextureUpload upload_;
};

}  // namespace sideray::bridge
