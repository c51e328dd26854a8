#include "bridge/transport/source_checks.h"

#include <optional>

#include "model/failure.h"

namespace sideray::bridge {
namespace {

struct Extent {
  int width = 0, height = 0;
};

Extent renderbuffer_extent(const gl::Functions& gl, uint32_t name) {
  Extent extent;
  gl.BindRenderbuffer(GL_RENDERBUFFER, name);
  gl.GetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_WIDTH, &extent.width);
  gl.GetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_HEIGHT, &extent.height);
  return extent;
}

Extent texture_extent(const gl::Functions& gl, uint32_t name, int level) {
  Extent extent;
  gl.GetTextureLevelParameteriv(name, level, GL_TEXTURE_WIDTH, &extent.width);
  gl.GetTextureLevelParameteriv(name, level, GL_TEXTURE_HEIGHT, &extent.height);
  return extent;
}

std::optional<Extent> depth_extent(const gl::Functions& gl) {
  const auto parameter = [&](GLenum name) {
    int value = 0;
    gl.GetFramebufferAttachmentParameteriv(gl.read_framebuffer, GL_DEPTH_ATTACHMENT, name, &value);
    return value;
  };
  const int type = parameter(GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE);
  if (type != GL_RENDERBUFFER && (type != GL_TEXTURE || gl.version < 45)) return std::nullopt;
  const auto name = static_cast<uint32_t>(parameter(GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME));
  if (type == GL_RENDERBUFFER) return renderbuffer_extent(gl, name);
  return texture_extent(gl, name, parameter(GL_FRAMEBUFFER_ATTACHMENT_TEXTURE_LEVEL));
}

}  // namespace

void require_context(const gl::Functions& gl) {
  if (!gl.GetString(GL_VERSION))
    fail(SIDERAY_INVALID_ARGUMENT,
         "service: no OpenGL context is current on this thread; make the one current that the service was created in");
}

void require_framebuffer(const gl::Functions& gl, uint32_t framebuffer) {
  if (framebuffer != 0 && gl.IsFramebuffer(framebuffer) != GL_TRUE)
    fail(SIDERAY_INVALID_ARGUMENT,
         "frame framebuffer {}: there is none of this name in the context that is current; framebuffers are not shared "
         "between contexts",
         framebuffer);
}

void require_rectangle_within(const gl::Functions& gl, const sideray_frame_source& in, uint32_t framebuffer) {
  if (framebuffer == 0 || !gl.attachment_sizes) return;
  const std::optional<Extent> extent = depth_extent(gl);
  if (!extent || extent->width == 0) return;
  if (in.width > extent->width - in.x || in.height > extent->height - in.y)
    fail(SIDERAY_INVALID_ARGUMENT, "frame rectangle {}x{} at {},{}: the depth is {}x{}; give a rectangle within it",
         in.width, in.height, in.x, in.y, extent->width, extent->height);
}

}  // namespace sideray::bridge
