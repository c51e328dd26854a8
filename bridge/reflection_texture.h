// The texture that holds what a frame's opaque surfaces mirror. GL thread.
#pragma once

#include <cstdint>

#include "bridge/texture_upload.h"
#include "gl/functions.h"
#include "gl/objects.h"
#include "rt/tracer.h"

namespace sideray::bridge {

class ReflectionTexture {
 public:
  // Uploads all of it. Returns the bytes moved. Needs guards over the pixel transfer state and the active unit's
  // textures.
  uint64_t upload(const gl::Functions& gl, const rt::ReflectionImage& image, bool persistent);
  void abandon();
  uint64_t bytes() const { return uint64_t{8} * width_ * height_; }
  uint32_t id() const { return texture_ ? texture_.id() : 0; }

 private:
  gl::Texture texture_;
  uint32_t width_ = 0, height_ = 0;
  TextureUpload upload_;
};

}  // namespace sideray::bridge
