#include "bridge/transport/read_target.h"

#include "bridge/transport/readback.h"
#include "bridge/transport/source_checks.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

// Attaches depth or stencil alone, since EXT_framebuffer_object has no attachment for both.
void attach(const gl::Functions& gl, GLenum attachment, const sideray_frame_source& in) {
  if (in.depth_renderbuffer != 0)
    gl.FramebufferRenderbuffer(gl.read_framebuffer, attachment, GL_RENDERBUFFER, in.depth_renderbuffer);
  else if (in.depth_texture_target == GL_TEXTURE_2D_ARRAY)
    gl.FramebufferTextureLayer(gl.read_framebuffer, attachment, in.depth_texture, 0, in.depth_layer);
  else
    gl.FramebufferTexture2D(gl.read_framebuffer, attachment, in.depth_texture_target, in.depth_texture, 0);
}

// Returns false for a renderbuffer without stencil, which is an error to attach. A texture is attached to find out.
bool may_have_stencil(const gl::Functions& gl, const sideray_frame_source& in) {
  if (in.depth_renderbuffer == 0) return true;
  GLint bits = 0;
  gl.BindRenderbuffer(GL_RENDERBUFFER, in.depth_renderbuffer);
  gl.GetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_STENCIL_SIZE, &bits);
  return bits > 0;
}

bool is_readable(const gl::Functions& gl) {
  return gl.CheckFramebufferStatus(gl.read_framebuffer) == GL_FRAMEBUFFER_COMPLETE;
}

// Returns the renderbuffer format that matches the framebuffer bound for reading.
GLenum storage_format(const DepthStencilFormat& format) {
  switch (format.layout) {
    case rt::DepthFormat::d16:
      return GL_DEPTH_COMPONENT16;
    case rt::DepthFormat::d24s8:
      return GL_DEPTH24_STENCIL8;
    case rt::DepthFormat::d32f_s8:
      return GL_DEPTH32F_STENCIL8;
    default:
      return format.depth_bits == 24 ? GL_DEPTH_COMPONENT24 : GL_DEPTH_COMPONENT32F;
  }
}

int samples_of(const gl::Functions& gl, uint32_t framebuffer) {
  GLint samples = 0;
  gl.BindFramebuffer(gl.draw_framebuffer, framebuffer);
  gl.GetIntegerv(GL_SAMPLES, &samples);
  return samples;
}

}  // namespace

ReadTarget::Bound ReadTarget::bind(const gl::Functions& gl, const sideray_frame_source& in, gl::StatePolicy policy) {
  const bool wraps = in.depth_texture != 0 || in.depth_renderbuffer != 0;
  if (!wraps) require_framebuffer(gl, in.framebuffer);
  const uint32_t framebuffer = wraps ? wrap_image(gl, in) : in.framebuffer;
  gl.BindFramebuffer(gl.read_framebuffer, framebuffer);
  require_rectangle_within(gl, in, framebuffer);
  Bound bound{framebuffer, in.x, in.y, false};
  if (samples_of(gl, framebuffer) > 0) {
    resolve(gl, framebuffer, in, policy);
    bound = {copy_.id(), 0, 0, true};
  }
  gl.BindFramebuffer(gl.read_framebuffer, bound.framebuffer);
  return bound;
}

// Wraps the host's image in a framebuffer, with stencil where the image has it.
uint32_t ReadTarget::wrap_image(const gl::Functions& gl, const sideray_frame_source& in) {
  if (!around_) around_ = gl::Framebuffer(gl);
  gl.BindFramebuffer(gl.read_framebuffer, around_.id());
  gl.ReadBuffer(GL_NONE);
  gl.BindFramebuffer(gl.draw_framebuffer, around_.id());
  gl.DrawBuffer(GL_NONE);
  attach(gl, GL_DEPTH_ATTACHMENT, in);
  if (may_have_stencil(gl, in)) {
    attach(gl, GL_STENCIL_ATTACHMENT, in);
    if (is_readable(gl)) return around_.id();
  }
  gl.FramebufferRenderbuffer(gl.read_framebuffer, GL_STENCIL_ATTACHMENT, GL_RENDERBUFFER, 0);
  if (is_readable(gl)) return around_.id();
  fail(
      SIDERAY_INVALID_ARGUMENT,
      "{} {}: no depth can be read from it; give a depth or packed depth-stencil image of this context, and its target",
      in.depth_renderbuffer ? "depth_renderbuffer" : "depth_texture",
      in.depth_renderbuffer ? in.depth_renderbuffer : in.depth_texture);
}

void ReadTarget::resolve(const gl::Functions& gl, uint32_t framebuffer, const sideray_frame_source& in,
                         gl::StatePolicy policy) {
  if (!gl.separate_framebuffers)
    fail(SIDERAY_UNSUPPORTED,
         "multisampled framebuffer: {} cannot copy one sample of its depth (OpenGL 3.0 or EXT_framebuffer_blit); give "
         "one with a sample a pixel",
         gl.renderer);
  gl.BindFramebuffer(gl.read_framebuffer, framebuffer);
  const DepthStencilFormat format = depth_stencil_format(gl, framebuffer == 0);
  allocate_copy(gl, storage_format(format), in.width, in.height);
  gl.BindFramebuffer(gl.read_framebuffer, framebuffer);
  gl.BindFramebuffer(gl.draw_framebuffer, copy_.id());
  // Restores initial state for the blit, which by the specification only the scissor test affects: on NVIDIA, copies of
  // 32-bit float depth with stencil failed with random state set, mostly where rasterizer discard was on.
  const gl::DrawGuard plain(gl, policy);
  const GLbitfield planes = GL_DEPTH_BUFFER_BIT | (format.has_stencil ? GL_STENCIL_BUFFER_BIT : 0u);
  gl.BlitFramebuffer(in.x, in.y, in.x + in.width, in.y + in.height, 0, 0, in.width, in.height, planes, GL_NEAREST);
}

void ReadTarget::allocate_copy(const gl::Functions& gl, uint32_t format, int32_t width, int32_t height) {
  if (copy_ && format == format_ && width == width_ && height == height_) return;
  copy_ = gl::Framebuffer(gl);
  copied_ = gl::Renderbuffer(gl);
  gl.BindRenderbuffer(GL_RENDERBUFFER, copied_.id());
  gl.RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
  gl.BindFramebuffer(gl.draw_framebuffer, copy_.id());
  const bool has_stencil = format == GL_DEPTH24_STENCIL8 || format == GL_DEPTH32F_STENCIL8;
  gl.FramebufferRenderbuffer(gl.draw_framebuffer, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, copied_.id());
  if (has_stencil)
    gl.FramebufferRenderbuffer(gl.draw_framebuffer, GL_STENCIL_ATTACHMENT, GL_RENDERBUFFER, copied_.id());
  gl.DrawBuffer(GL_NONE);
  gl.BindFramebuffer(gl.read_framebuffer, copy_.id());
  gl.ReadBuffer(GL_NONE);
  if (!is_readable(gl))
    fail(SIDERAY_UNSUPPORTED,
         "multisampled framebuffer: the driver makes no single-sampled copy of its depth; resolve it");
  format_ = format, width_ = width, height_ = height;
}

void ReadTarget::abandon() {
  around_.abandon(), copy_.abandon(), copied_.abandon();
  format_ = 0, width_ = height_ = 0;
}

}  // namespace sideray::bridge
