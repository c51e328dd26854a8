#include "gl/targets/opaque_levels.h"

#include <algorithm>
#include <bit>

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
  width_ = width, height_ = height;
  for (int level = 0; level < levels(); ++level)
    gl_.TexImage2D(GL_TEXTURE_2D, level, GL_RGBA16F, width_of(level), height_of(level), 0, GL_RGBA, GL_FLOAT, nullptr);
  try {
    check_allocation(gl_, "the opaque picture's levels");
    finer_ = Framebuffer(gl_), coarser_ = Framebuffer(gl_);
  } catch (...) {
    release();
    throw;
  }
}

int OpaqueLevels::levels() const {
  return std::bit_width(std::max(width_, height_));
}

GLsizei OpaqueLevels::width_of(int level) const {
  return static_cast<GLsizei>(std::max(width_ >> level, 1u));
}

GLsizei OpaqueLevels::height_of(int level) const {
  return static_cast<GLsizei>(std::max(height_ >> level, 1u));
}

void OpaqueLevels::bind(GLenum target, const Framebuffer& framebuffer, int level) const {
  gl_.BindFramebuffer(target, framebuffer.id());
  gl_.FramebufferTexture2D(target, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_.id(), level);
}

void OpaqueLevels::copy(const RasterTargets& source) {
  fit(source.width(), source.height());
  source.bind_resolve();
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture_.id());
  gl_.CopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
  // glGenerateMipmap may halve sides of odd length in any way: NVIDIA's driver (580.159) leaves out the last row, which
  // moves what rough glass shows by a texel of each such level.
  for (int level = 1; level < levels(); ++level) {
    bind(GL_READ_FRAMEBUFFER, finer_, level - 1);
    bind(GL_DRAW_FRAMEBUFFER, coarser_, level);
    gl_.BlitFramebuffer(0, 0, width_of(level - 1), height_of(level - 1), 0, 0, width_of(level), height_of(level),
                        GL_COLOR_BUFFER_BIT, GL_LINEAR);
  }
}

void OpaqueLevels::release() {
  texture_.reset(), finer_.reset(), coarser_.reset();
  width_ = height_ = 0;
}

}  // namespace sideray::gl
