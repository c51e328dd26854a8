#include "gl/targets/opaque_levels.h"

#include "gl/resources/raster_textures.h"

namespace sideray::gl {

void OpaqueLevels::fit(uint32_t width, uint32_t height) {
  if (width_ == width && height_ == height) return;
  release();
  texture_ = Texture(gl_);
  gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture_.id());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 0, GL_RGBA,
                 GL_FLOAT, nullptr);
  try {
    check_allocation(gl_, "the opaque picture's levels");
  } catch (...) {
    release();
    throw;
  }
  width_ = width, height_ = height;
}

void OpaqueLevels::copy(const RasterTargets& source) {
  fit(source.width(), source.height());
  source.bind_resolve();
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture_.id());
  gl_.CopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
  gl_.GenerateMipmap(GL_TEXTURE_2D);
}

void OpaqueLevels::release() {
  texture_.reset();
  width_ = height_ = 0;
}

}  // namespace sideray::gl
