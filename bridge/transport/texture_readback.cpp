#include "bridge/transport/texture_readback.h"

#include "model/failure.h"

namespace sideray::bridge {
namespace {

// Returns whether the texture attached for reading holds halfs.
bool holds_halfs(const gl::Functions& gl) {
  if (!gl.attachment_sizes) return false;
  const auto parameter = [&](GLenum name) {
    GLint value = 0;
    gl.GetFramebufferAttachmentParameteriv(gl.read_framebuffer, GL_COLOR_ATTACHMENT0, name, &value);
    return value;
  };
  return parameter(GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE) == GL_FLOAT &&
         parameter(GL_FRAMEBUFFER_ATTACHMENT_RED_SIZE) == 16;
}

}  // namespace

void TextureReadback::start(const gl::Functions& gl, const char* name, uint32_t texture, Rectangle where,
                            const ReadTexel& texel) {
  bytes_ = texture == 0 ? 0 : uint64_t{where.width} * where.height * texel.bytes;
  if (bytes_ == 0) return;
  if (!frame_) frame_ = gl::Framebuffer(gl);
  gl.BindFramebuffer(gl.read_framebuffer, frame_.id());
  gl.FramebufferTexture2D(gl.read_framebuffer, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
  if (gl.CheckFramebufferStatus(gl.read_framebuffer) != GL_FRAMEBUFFER_COMPLETE)
    fail(SIDERAY_INVALID_ARGUMENT, "{} {}: cannot be read; give a {} 2D texture of the framebuffer's size", name,
         texture, texel.wanted);
  are_halfs_ = texel.may_be_halfs && holds_halfs(gl);
  if (are_halfs_) bytes_ /= 2;
  if (!buffer_) buffer_ = gl::Buffer(gl);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
  if (capacity_ < bytes_) gl.BufferData(GL_PIXEL_PACK_BUFFER, static_cast<GLsizeiptr>(bytes_), nullptr, GL_STREAM_READ);
  capacity_ = capacity_ < bytes_ ? bytes_ : capacity_;
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(static_cast<GLint>(where.x), static_cast<GLint>(where.y), static_cast<GLsizei>(where.width),
                static_cast<GLsizei>(where.height), texel.format, are_halfs_ ? GL_HALF_FLOAT : texel.type, nullptr);
}

void TextureReadback::map(const gl::Functions& gl) {
  if (bytes_ == 0) return;
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
  mapped_ = gl::map_to_read(gl, GL_PIXEL_PACK_BUFFER, bytes_);
  if (!mapped_)
    fail(SIDERAY_OUT_OF_MEMORY, "readback: the driver could not map {} bytes; lower the resolution", bytes_);
}

void TextureReadback::finish(const gl::Functions& gl) {
  if (!mapped_) return;
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
  gl.UnmapBuffer(GL_PIXEL_PACK_BUFFER);
  mapped_ = nullptr;
}

void TextureReadback::abandon() {
  buffer_.abandon();
  frame_.abandon();
  bytes_ = capacity_ = 0;
  mapped_ = nullptr;
}

}  // namespace sideray::bridge
