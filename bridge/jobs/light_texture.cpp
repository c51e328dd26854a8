#include "bridge/jobs/light_texture.h"

#include <utility>
#include <vector>

#include "bridge/transport/tile_rectangles.h"
#include "model/failure.h"

namespace sideray::bridge {

void LightTexture::prepare(const gl::Functions& gl, const LightImage& image) {
  if (now_.fits(image) || next_.fits(image)) return;
  next_ = {};
  Storage made{gl::Texture(gl), image.width, image.height};
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl.BindTexture(GL_TEXTURE_2D, made.texture.id());
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, static_cast<GLsizei>(image.width), static_cast<GLsizei>(image.height), 0,
                GL_RGBA, GL_HALF_FLOAT, nullptr);
  if (gl.GetError() != GL_NO_ERROR)
    fail(SIDERAY_OUT_OF_MEMORY, "{} of {}x{}: the driver has no room; lower the resolution", image.what,
         image.width, image.height);
  next_ = std::move(made);
}

uint64_t LightTexture::upload(const gl::Functions& gl, const LightImage& image,
                                   const rt::WantedTiles* wanted, const UploadWay& way) {
  prepare(gl, image);
  const bool is_new = !now_.fits(image);
  if (is_new) now_ = std::exchange(next_, {});
  std::vector<Rectangle> parts{{0, 0, image.width, image.height}};
  if (wanted && !wanted->tiles.empty() && !is_new)
    parts = rectangles_around(gl, wanted->tiles, image.width, image.height);
  std::vector<TexturePiece> pieces;
  for (const Rectangle& part : parts)
    pieces.push_back({GL_TEXTURE_2D, now_.texture.id(), 0, half4, part,
                      reinterpret_cast<const std::byte*>(image.halfs), image.width});
  return upload_.send(gl, pieces, way);
}

void LightTexture::abandon() {
  for (Storage* storage : {&now_, &next_}) {
    storage->texture.abandon();
    storage->width = storage->height = 0;
  }
  upload_.abandon();
}

}  // namespace sideray::bridge
