// Holds a texture of light on a frame's opaque pixels: what they mirror, or the light of other surfaces. GL thread.
#pragma once

#include <cstdint>

#include "bridge/transport/texture_upload.h"
#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "rt/reach/wanted_tiles.h"

namespace sideray::bridge {

// Refers to an image of four halfs a pixel. `what` names it in errors.
struct LightImage {
  const char* what;
  uint32_t width, height;
  const uint16_t* halfs;
  bool changed;  // since the last upload
};

class LightTexture {
 public:
  // Uploads the wanted tiles (null: all), and everything where the texture is new. Returns the bytes moved. Needs
  // guards over the pixel transfer state and the active unit's textures.
  uint64_t upload(const gl::Functions& gl, const LightImage& image, const rt::WantedTiles* wanted,
                  const UploadWay& way);
  // Does the same as in CacheTextures.
  void prepare(const gl::Functions& gl, const LightImage& image);
  void abandon();
  uint64_t bytes() const { return uint64_t{8} * now_.width * now_.height; }
  uint32_t id() const { return now_.texture.id(); }

 private:
  struct Storage {
    gl::Texture texture;
    uint32_t width = 0, height = 0;
    bool fits(const LightImage& image) const { return width == image.width && height == image.height; }
  };
  Storage now_, next_;
  TextureUpload upload_;
};

}  // namespace sideray::bridge
