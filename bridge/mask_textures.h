// The textures that hold a frame's shadow and ambient occlusion masks. GL thread.
#pragma once

#include <cstdint>

#include "bridge/texture_upload.h"
#include "gl/functions.h"
#include "gl/objects.h"
#include "rt/tracer.h"

namespace sideray::bridge {

class MaskTextures {
 public:
  // Uploads all of both masks, as far as there are any. Returns the bytes moved. Needs guards over the pixel transfer
  // state and the active unit's textures.
  uint64_t upload(const gl::Functions& gl, const rt::OcclusionMasks& masks, bool persistent);
  void abandon();
  uint64_t bytes() const { return uint64_t{width_} * height_ * (layers_ + (ambient_ ? 1u : 0u)); }
  uint32_t shadow() const { return shadow_ ? shadow_.id() : 0; }     // 2D array
  uint32_t ambient() const { return ambient_ ? ambient_.id() : 0; }  // 2D

 private:
  void allocate(const gl::Functions& gl, const rt::OcclusionMasks& masks);

  gl::Texture shadow_, ambient_;
  uint32_t width_ = 0, height_ = 0, layers_ = 0;
  TextureUpload upload_;
};

}  // namespace sideray::bridge
