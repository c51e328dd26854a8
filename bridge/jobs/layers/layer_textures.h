// Holds the textures of a traced frame, which are updated tile by tile. GL thread.
#pragma once

#include <cstdint>
#include <vector>

#include "bridge/jobs/layers/layer_encoding.h"
#include "bridge/transport/texture_upload.h"
#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "rt/composite/composite_image.h"
#include "rt/layers/layer_request.h"

namespace sideray::bridge {

// Its calls need guards over the pixel transfer state and the active unit's textures.
class CacheTextures {
 public:
  // Uploads the layers in use of dirty tiles; after a change of size or format, everything. Beyond a pixel's last layer
  // only the distance, 0, may be read. Returns the bytes moved.
  uint64_t upload(const gl::Functions& gl, const rt::LayerCache& cache, const LayerEncoding& encoding,
                  const UploadWay& way);
  // Makes the next upload move everything.
  void invalidate() { stale_ = true; }
  // Allocates for an upload with the same arguments, which then cannot fail; until then the textures stay as they are.
  // Throws Failure (OUT_OF_MEMORY, GL_FAILED). No other OpenGL error may be pending.
  void prepare(const gl::Functions& gl, const rt::LayerCache& cache, const LayerEncoding& encoding);
  void abandon();
  uint64_t bytes() const;
  uint32_t radiance() const { return now_.radiance.id(); }
  uint32_t distance() const { return now_.distance.id(); }
  uint32_t surface_id() const { return now_.surface_id.id(); }
  // 0 where the cache has no whole pixels.
  uint32_t whole_radiance() const { return now_.whole ? now_.whole_radiance.id() : 0; }
  uint32_t whole_transmittance() const { return now_.whole ? now_.whole_transmittance.id() : 0; }

 private:
  // Points to a layer's texels as the textures hold them.
  struct Texels {
    const std::byte *radiance, *surface_id;
  };
  struct Storage {
    gl::Texture radiance, distance, surface_id, whole_radiance, whole_transmittance;
    uint32_t width = 0, height = 0, layers = 0;
    bool whole = false;
    LayerEncoding encoding;
    bool fits(const rt::LayerCache& cache, const LayerEncoding& wanted) const;
    void abandon();
  };
  Texels encode(const rt::LayerCache& cache, const LayerEncoding& encoding, uint32_t layer,
                const std::vector<Rectangle>& rectangles);

  Storage now_, next_;
  bool stale_ = false;
  RadianceTable radiance_table_;
  std::vector<uint16_t> encoded_radiance_;  // the cache's radiance, encoded for the host
  std::vector<float> encoded_ids_;
  void add_whole(const gl::Functions& gl, const rt::LayerCache& cache, const Storage& to,
                 const std::vector<uint8_t>& dirty, rt::Executor& executor, std::vector<TexturePiece>& pieces);

  std::vector<uint8_t> tile_layers_;  // layers in use of each tile in the textures
  std::vector<uint8_t> tile_whole_;   // 1 = the textures hold whole pixels there
  TextureUpload upload_;
};

class CompositeTextures {
 public:
  uint64_t upload(const gl::Functions& gl, const rt::CompositeImage& image, const UploadWay& way);
  // Makes the next upload move everything.
  void invalidate() { stale_ = true; }
  // Does the same as in CacheTextures.
  void prepare(const gl::Functions& gl, const rt::CompositeImage& image);
  void abandon();
  uint64_t bytes() const { return uint64_t{now_.width} * now_.height * 2 * half4.bytes; }
  uint32_t radiance() const { return now_.radiance.id(); }
  uint32_t transmittance() const { return now_.transmittance.id(); }

 private:
  struct Storage {
    gl::Texture radiance, transmittance;
    uint32_t width = 0, height = 0;
    bool fits(const rt::CompositeImage& image) const { return width == image.width && height == image.height; }
    void abandon();
  };
  Storage now_, next_;
  bool stale_ = false;
  TextureUpload upload_;
};

}  // namespace sideray::bridge
