#include "preload/gl/depth_target.h"

#include <sideray/sideray.hpp>

#include "preload/gl/objects.h"

namespace sideray::run {

DepthTarget::~DepthTarget() {
  const Functions& gl = real();
  if (framebuffer_ != 0) gl.DeleteFramebuffers(1, &framebuffer_);
  for (const GLuint texture : {depth_, marks_})
    if (texture != 0) gl.DeleteTextures(1, &texture);
}

void DepthTarget::make(const std::array<GLint, 4>& viewport) {
  const Functions& gl = real();
  gl.ActiveTexture(GL_TEXTURE0);
  if (gl.BindBuffer) gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  if (framebuffer_ == 0) gl.GenFramebuffers(1, &framebuffer_), depth_ = make_texture(), marks_ = make_texture();
  const GLint width = viewport[0] + viewport[2], height = viewport[1] + viewport[3];
  if (width == width_ && height == height_) return;
  width_ = width, height_ = height;
  gl.BindTexture(GL_TEXTURE_2D, marks_);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, width, height, 0, GL_RED, GL_UNSIGNED_BYTE, nullptr);
  gl.BindTexture(GL_TEXTURE_2D, depth_);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, width, height, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
}

void DepthTarget::copy_depth() {
  const Functions& gl = real();
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, depth_);
  gl.CopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, width_, height_);
}

void DepthTarget::begin() {
  const Functions& gl = real();
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, marks_, 0);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_, 0);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw Error(SIDERAY_UNSUPPORTED, "the driver cannot draw beside a depth texture");
  gl.Disable(GL_SCISSOR_TEST);
  gl.ColorMask(1, 1, 1, 1);
  gl.ClearColor(0, 0, 0, 0);
  gl.Clear(GL_COLOR_BUFFER_BIT);
}

}  // namespace sideray::run
