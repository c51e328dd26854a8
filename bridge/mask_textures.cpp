#include "bridge/mask_textures.h"

#include <vector>

#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr TexelFormat byte1{GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1, 1};

void set_nearest(const gl::Functions& gl, GLenum target) {
  gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
}

}  // namespace

void MaskTextures::allocate(const gl::Functions& gl, const rt::OcclusionMasks& masks) {
  width_ = masks.width, height_ = masks.height, layers_ = masks.layers;
  const auto width = static_cast<GLsizei>(width_), height = static_cast<GLsizei>(height_);
  shadow_ = layers_ > 0 ? gl::Texture(gl) : gl::Texture();
  ambient_ = masks.open.empty() ? gl::Texture() : gl::Texture(gl);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  if (shadow_) {
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, shadow_.id());
    set_nearest(gl, GL_TEXTURE_2D_ARRAY);
    gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_R8, width, height, static_cast<GLsizei>(layers_), 0, GL_RED,
                  GL_UNSIGNED_BYTE, nullptr);
  }
  if (ambient_) {
    gl.BindTexture(GL_TEXTURE_2D, ambient_.id());
    set_nearest(gl, GL_TEXTURE_2D);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, width, height, 0, GL_RED, GL_UNSIGNED_BYTE, nullptr);
  }
  if (gl.GetError() != GL_NO_ERROR) {
    abandon();
    fail(SIDERAY_OUT_OF_MEMORY, "masks of {}x{}, {} layers: the driver has no room; lower the resolution", masks.width,
         masks.height, masks.layers);
  }
}

uint64_t MaskTextures::upload(const gl::Functions& gl, const rt::OcclusionMasks& masks, bool persistent) {
  const bool ambient = !masks.open.empty();
  if (width_ != masks.width || height_ != masks.height || layers_ != masks.layers || bool(ambient_) != ambient)
    allocate(gl, masks);
  std::vector<TexturePiece> pieces;
  const Rectangle all{0, 0, width_, height_};
  for (uint32_t layer = 0; layer < layers_; ++layer)
    pieces.push_back({GL_TEXTURE_2D_ARRAY, shadow_.id(), layer, byte1, all,
                      reinterpret_cast<const std::byte*>(&masks.lit[size_t{layer} * width_ * height_]), width_});
  if (ambient)
    pieces.push_back(
        {GL_TEXTURE_2D, ambient_.id(), 0, byte1, all, reinterpret_cast<const std::byte*>(masks.open.data()), width_});
  return upload_.send(gl, pieces, persistent);
}

void MaskTextures::abandon() {
  shadow_.abandon(), ambient_.abandon();
  upload_.abandon();
  width_ = height_ = layers_ = 0;
}

}  // namespace sideray::bridge
