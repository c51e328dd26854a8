// The textures that hold a frame's shadow and ambient occlusion masks. GL thread.
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
  // Which masks of lights, by layer, and of the sky, behind them, the textures hold already.
  using Held = std::function<bool(uint32_t layer)>;
  // Uploads the masks that are not held, as far as there are any, and all of them where the textures are new. Of tiles that
  // are not `wanted` nothing is uploaded; null: all are. Returns the bytes moved. Needs guards over the pixel transfer state and the active unit's textures.
  uint64_t upload(const gl::Functions& gl, const rt::OcclusionMasks& masks, const Held& held,
                  const rt::WantedTiles* wanted, const UploadWay& way);
  // As in CacheTextures.
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
  uint32_t answers() const { return now_.answers.id(); }  // 2D, or 0; of a frame in which some were missing

 private:
  struct Storage {
    gl::Texture shadow, ambient, tint, depth, answers;
    uint32_t width = 0, height = 0, layers = 0, tints = 0;
    std::vector<Rectangle> tinted;  // of each place: outside of it nothing is tinted
    bool fits(const rt::OcclusionMasks& masks) const;
    void abandon();
  };
  Storage now_, next_;
  TextureUpload upload_;
};

}  // namespace sideray::bridge
