// Reads a rectangle of a texture into memory. GL thread; reused from frame to frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bridge/transport/texture_upload.h"
#include "gl/context/functions.h"
#include "gl/resources/objects.h"

namespace sideray::bridge {

// Says how a texel is read.
struct ReadTexel {
  uint32_t format, type, bytes;
  const char* wanted;  // name of the texture's format, for errors
  bool may_be_halfs = false;  // a texture of halfs is read as halfs: are_halfs()
};
inline constexpr ReadTexel rgba_floats{GL_RGBA, GL_FLOAT, 16, "RGBA32F"};
inline constexpr ReadTexel rgba_floats_or_halfs{GL_RGBA, GL_FLOAT, 16, "RGBA32F or RGBA16F", true};
inline constexpr ReadTexel rg_floats{GL_RG, GL_FLOAT, 8, "RG32F"};
inline constexpr ReadTexel red_bytes{GL_RED, GL_UNSIGNED_BYTE, 1, "R8"};

class TextureReadback {
 public:
  // `name` is the input's, for errors; texture 0: nothing is read. Needs guards over the pixel transfer state and
  // framebuffers. Throws Failure (INVALID_ARGUMENT, OUT_OF_MEMORY).
  void start(const gl::Functions& gl, const char* name, uint32_t texture, Rectangle where, const ReadTexel& texel);
  // Blocks where the bytes are not ready; texels() is valid until finish(). Needs a guard over the pack buffer.
  void map(const gl::Functions& gl);
  void finish(const gl::Functions& gl);
  void abandon();
  uint64_t bytes() const { return bytes_; }  // 0 = nothing was read
  bool are_halfs() const { return are_halfs_; }

  template <typename Texel>
  std::span<const Texel> texels() const {
    return {static_cast<const Texel*>(mapped_), mapped_ ? bytes_ / sizeof(Texel) : 0};
  }

 private:
  gl::Buffer buffer_;
  gl::Framebuffer frame_;
  uint64_t bytes_ = 0, capacity_ = 0;
  bool are_halfs_ = false;
  const void* mapped_ = nullptr;
};

}  // namespace sideray::bridge
