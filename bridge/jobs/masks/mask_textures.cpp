#include "bridge/jobs/masks/mask_textures.h"

#include <utility>
#include <vector>

#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr TexelFormat byte1{GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1};

void set_nearest(const gl::Functions& gl, GLenum target) {
  gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
}

}  // namespace

bool MaskTextures::Storage::fits(const rt::OcclusionMasks& masks) const {
  return width == masks.width && height == masks.height && layers == masks.layers &&
         bool(ambient) != masks.open.empty();
}

void MaskTextures::Storage::abandon() {
  shadow.abandon(), ambient.abandon();
  width = height = layers = 0;
}

void MaskTextures::prepare(const gl::Functions& gl, const rt::OcclusionMasks& masks) {
  if (now_.fits(masks) || next_.fits(masks)) return;
  next_ = {};
  Storage made;
  made.width = masks.width, made.height = masks.height, made.layers = masks.layers;
  const auto width = static_cast<GLsizei>(made.width), height = static_cast<GLsizei>(made.height);
  if (made.layers > 0) made.shadow = gl::Texture(gl);
  if (!masks.open.empty()) made.ambient = gl::Texture(gl);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  if (made.shadow) {
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, made.shadow.id());
    set_nearest(gl, GL_TEXTURE_2D_ARRAY);
    gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_R8, width, height, static_cast<GLsizei>(made.layers), 0, GL_RED,
                  GL_UNSIGNED_BYTE, nullptr);
  }
  if (made.ambient) {
    gl.BindTexture(GL_TEXTURE_2D, made.ambient.id());
    set_nearest(gl, GL_TEXTURE_2D);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, width, height, 0, GL_RED, GL_UNSIGNED_BYTE, nullptr);
  }
  if (gl.GetError() != GL_NO_ERROR)
    fail(SIDERAY_OUT_OF_MEMORY, "masks of {}x{}, {} layers: the driver has no room; lower the resolution", masks.width,
         masks.height, masks.layers);
  next_ = std::move(made);
}

uint64_t MaskTextures::upload(const gl::Functions& gl, const rt::OcclusionMasks& masks, const Held& held,
                              const UploadWay& way) {
  prepare(gl, masks);
  const bool is_new = !now_.fits(masks);
  if (is_new) now_ = std::exchange(next_, {});
  std::vector<TexturePiece> pieces;
  const Rectangle all{0, 0, masks.width, masks.height};
  for (uint32_t layer = 0; layer < masks.layers; ++layer) {
    if (!is_new && held(layer)) continue;
    const auto* texels = reinterpret_cast<const std::byte*>(&masks.lit[size_t{layer} * all.width * all.height]);
    pieces.push_back({GL_TEXTURE_2D_ARRAY, now_.shadow.id(), layer, byte1, all, texels, all.width});
  }
  if (now_.ambient && (is_new || !held(masks.layers)))
    pieces.push_back({GL_TEXTURE_2D, now_.ambient.id(), 0, byte1, all,
                      reinterpret_cast<const std::byte*>(masks.open.data()), all.width});
  return upload_.send(gl, pieces, way);
}

void MaskTextures::abandon() {
  now_.abandon(), next_.abandon();
  upload_.abandon();
}

}  // namespace sideray::bridge
