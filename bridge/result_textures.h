// The textures that hold a traced frame, updated tile by tile. GL thread.
#pragma once

#include <cstdint>
#include <vector>

#include "bridge/layer_encoding.h"
#include "bridge/texture_upload.h"
#include "gl/functions.h"
#include "gl/objects.h"
#include "rt/tracer.h"

namespace sideray::bridge {

// Calls need guards over the pixel transfer state and the active unit's textures.
class CacheTextures {
 public:
  // Uploads of the dirty tiles the layers that hold something; all of everything after a change of size or format.
  // Beyond a pixel's last layer only its distance, 0, is to be read. Returns the bytes moved.
  uint64_t upload(const gl::Functions& gl, const rt::LayerCache& cache, const LayerEncoding& encoding, bool persistent);
  // The next upload moves everything.
  void invalidate() { width_ = height_ = 0; }
  void abandon();
  uint64_t bytes() const { return bytes_; }
  uint32_t radiance() const { return radiance_.id(); }
  uint32_t distance() const { return distance_.id(); }
  uint32_t surface_id() const { return surface_id_.id(); }

 private:
  // Texels of a layer as the textures hold them.
  struct Texels {
    const std::byte *radiance, *surface_id;
  };
  void allocate(const gl::Functions& gl, const rt::LayerCache& cache);
  Texels encode(const rt::LayerCache& cache, uint32_t layer, const std::vector<Rectangle>& rectangles);

  gl::Texture radiance_, distance_, surface_id_;
  uint32_t width_ = 0, height_ = 0, layers_ = 0;
  LayerEncoding encoding_;
  RadianceTable radiance_table_;
  std::vector<uint16_t> encoded_radiance_;  // as the cache's, where the encoding changes it
  std::vector<float> encoded_ids_;
  uint64_t bytes_ = 0;
  std::vector<uint8_t> tile_layers_;  // that the textures hold something in
  TextureUpload upload_;
};

class CompositeTextures {
 public:
  uint64_t upload(const gl::Functions& gl, const rt::CompositeImage& image, bool persistent);
  // The next upload moves everything.
  void invalidate() { width_ = height_ = 0; }
  void abandon();
  uint64_t bytes() const { return bytes_; }
  uint32_t radiance() const { return radiance_.id(); }
  uint32_t transmittance() const { return transmittance_.id(); }

 private:
  gl::Texture radiance_, transmittance_;
  uint32_t width_ = 0, height_ = 0;
  uint64_t bytes_ = 0;
  TextureUpload upload_;
};

}  // namespace sideray::bridge
