// A rectangle of a floating-point texture on its way into memory. GL thread; reused from frame to frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bridge/texture_upload.h"
#include "gl/functions.h"
#include "gl/objects.h"

namespace sideray::bridge {

class FloatReadback {
 public:
  // `name` is the input's, for errors; texture 0: nothing is read. `channels`: 2 or 4 floats a texel. Needs guards over
  // the pixel transfer state and framebuffers. Throws Failure (INVALID_ARGUMENT, OUT_OF_MEMORY).
  void start(const gl::Functions& gl, const char* name, uint32_t texture, Rectangle where, uint32_t channels);
  // Blocks where the bytes are not there; texels() then holds until finish. Needs a guard over the pack buffer.
  void map(const gl::Functions& gl);
  void finish(const gl::Functions& gl);
  void abandon();
  uint64_t bytes() const { return bytes_; }  // 0 = nothing was read

  template <typename Texel>
  std::span<const Texel> texels() const {
    return {static_cast<const Texel*>(mapped_), mapped_ ? bytes_ / sizeof(Texel) : 0};
  }

 private:
  gl::Buffer buffer_;
  gl::Framebuffer frame_;
  uint64_t bytes_ = 0, capacity_ = 0;
  const void* mapped_ = nullptr;
};

}  // namespace sideray::bridge
