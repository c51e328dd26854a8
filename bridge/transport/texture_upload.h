// Moves texels from memory into textures: directly, or through a buffer that stays mapped. GL thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "rt/base/executor.h"

namespace sideray::bridge {

struct TexelFormat {
  uint32_t internal, format, type;
  uint32_t bytes;  // of a texel
};
inline constexpr TexelFormat half4{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 8};
inline constexpr TexelFormat single{GL_R32F, GL_RED, GL_FLOAT, 4};
inline constexpr TexelFormat id32{GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, 4};

struct Rectangle {
  uint32_t x, y, width, height;
};

// Describes a rectangle of one layer of a texture, 2D or 2D array, and the image that it is cut from.
struct TexturePiece {
  uint32_t target, texture, layer;
  TexelFormat format;
  Rectangle where;
  const std::byte* layer_texels;  // first texel of the whole layer
  uint32_t row_texels;            // row length of the whole layer
};

// Says how texels get into textures: with `persistent`, the threads of `copiers` copy them into a buffer that stays
// mapped; otherwise the driver reads them directly.
struct UploadWay {
  bool persistent;
  rt::Executor& copiers;
};

class TextureUpload {
 public:
  // Returns the bytes moved. A persistent way needs buffer_storage; without memory for its buffer, the driver reads
  // texels directly. Needs guards over the pixel transfer state and the active unit's textures. No OpenGL error may be
  // pending.
  uint64_t send(const gl::Functions& gl, std::span<const TexturePiece> pieces, const UploadWay& way);
  void abandon();

 private:
  // Holds a mapped buffer, and a fence that signals once the driver has read the last upload from it.
  struct Staging {
    gl::Buffer buffer;
    gl::Fence read;
    std::byte* mapped = nullptr;
    uint64_t capacity = 0;
  };
  Staging* require_staging(const gl::Functions& gl, uint64_t bytes);

  std::array<Staging, 2> stagings_;
};

}  // namespace sideray::bridge
