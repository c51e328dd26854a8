// The texture that holds what a frame's opaque surfaces mirror. GL thread.
#pragma once

#include <cstdint>

#include "bridge/transport/texture_upload.h"
#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "rt/reach/wanted_tiles.h"
#include "rt/reflections/reflection_request.h"

namespace sideray::bridge {

class ReflectionTexture {
 public:
  // Uploads the tiles that are wanted, null: all of it, and all where the texture is new. Returns the bytes moved. Needs guards
  // over the pixel transfer state and the active unit's textures.
  uint64_t upload(const gl::Functions& gl, const rt::ReflectionImage& image, const rt::WantedTiles* wanted,
                  const UploadWay& way);
  // As in CacheTextures.
  void prepare(const gl::Functions& gl, const rt::ReflectionImage& image);
  void abandon();
  uint64_t bytes() const { return uint64_t{8} * now_.width * now_.height; }
  uint32_t id() const { return now_.texture.id(); }

 private:
  struct Storage {
    gl::Texture texture;
    uint32_t width = 0, height = 0;
    bool fits(const rt::ReflectionImage& image) const { return width == image.width && height == image.height; }
  };
  Storage now_, next_;
  TextureUpload upload_;
};

}  // namespace sideray::bridge
