#include "gl/targets/distortion_targets.h"

#include "gl/resources/raster_textures.h"
#include "model/failure.h"

namespace sideray::gl {

// Uses full floats: offsets are in picture heights, and halfs are too coarse where a pixel is a 2000th.
Texture DistortionTargets::make_texture() const {
  Texture texture(gl_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture.id());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), 0, GL_RGBA,
                 GL_FLOAT, nullptr);
  return texture;
}

void DistortionTargets::fit(const RasterTargets& targets) {
  if (width_ == targets.width() && height_ == targets.height() && depth_stencil_ == targets.depth_stencil()) return;
  width_ = targets.width(), height_ = targets.height(), depth_stencil_ = targets.depth_stencil();
  try {
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    offsets_ = make_texture();
    picture_ = make_texture();
    check_allocation(gl_, "distortion");
    framebuffer_ = Framebuffer(gl_);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, offsets_.id(), 0);
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, depth_stencil_, 0);
    if (const GLenum status = gl_.CheckFramebufferStatus(GL_FRAMEBUFFER); status != GL_FRAMEBUFFER_COMPLETE)
      fail(SIDERAY_UNSUPPORTED, "distortion framebuffer: incomplete ({:#x}) on {}; use another device", status,
           gl_.renderer);
  } catch (...) {
    release();
    throw;
  }
}

void DistortionTargets::release() {
  offsets_.reset(), picture_.reset(), framebuffer_.reset();
  width_ = height_ = depth_stencil_ = 0;
}

void DistortionTargets::bind_offsets() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  gl_.Viewport(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
}

void DistortionTargets::copy(const RasterTargets& source) {
  source.bind_resolve();
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, picture_.id());
  gl_.CopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
}

}  // namespace sideray::gl
