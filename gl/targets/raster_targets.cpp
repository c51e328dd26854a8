#include "gl/targets/raster_targets.h"

#include <algorithm>

#include "gl/resources/raster_textures.h"
#include "model/failure.h"

namespace sideray::gl {

Texture RasterTargets::make_texture(uint32_t internal_format, uint32_t format, uint32_t type) const {
  Texture texture(gl_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture.id());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal_format), static_cast<GLsizei>(width_),
                 static_cast<GLsizei>(height_), 0, format, type, nullptr);
  return texture;
}

void RasterTargets::check_complete(const char* what) const {
  const GLenum status = gl_.CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    fail(SIDERAY_UNSUPPORTED, "{} framebuffer: incomplete ({:#x}) on {}; use another device", what, status,
         gl_.renderer);
}

void RasterTargets::attach_gbuffer() {
  gbuffer_ = Framebuffer(gl_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, gbuffer_.id());
  std::vector<GLenum> targets;
  const auto add = [&](const Texture& texture) {
    const auto point = static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + targets.size());
    targets.push_back(texture ? point : GL_NONE);
    if (texture) gl_.FramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, texture.id(), 0);
  };
  for (const Texture& texture : gbuffer_textures_) add(texture);
  for (const Texture& texture : lobe_textures_) add(texture);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, depth_stencil_.id(), 0);
  gl_.DrawBuffers(static_cast<GLsizei>(targets.size()), targets.data());
  check_complete("G-buffer");
}

void RasterTargets::attach() {
  attach_gbuffer();
  const auto attach_texture = [&](GLenum point, const Texture& texture) {
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, texture.id(), 0);
  };
  resolve_ = Framebuffer(gl_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, resolve_.id());
  attach_texture(GL_COLOR_ATTACHMENT0, color_);
  check_complete("colour");

  frame_ = Framebuffer(gl_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, frame_.id());
  attach_texture(GL_COLOR_ATTACHMENT0, color_);
  attach_texture(GL_DEPTH_STENCIL_ATTACHMENT, depth_stencil_);
  check_complete("frame");
}

void RasterTargets::allocate_lobes() {
  for (uint32_t i = 0; i < lobe::count; ++i)
    lobe_textures_[i] = lobes_ & (1u << i) ? make_texture(GL_RGBA16F, GL_RGBA, GL_FLOAT) : Texture();
}

void RasterTargets::allocate_ids() {
  const bool brushed = (lobes_ & lobe::anisotropy) != 0;
  gbuffer_textures_[floating_targets] =
      make_texture(brushed ? GL_RGBA32UI : GL_RG32UI, brushed ? GL_RGBA_INTEGER : GL_RG_INTEGER, GL_UNSIGNED_INT);
}

void RasterTargets::set_lobes(uint32_t lobes) {
  if (lobes == lobes_ || width_ == 0) return;
  const bool other_ids = ((lobes ^ lobes_) & lobe::anisotropy) != 0;
  lobes_ = lobes;
  try {
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    allocate_lobes();
    if (other_ids) allocate_ids();
    check_allocation(gl_, "picture");
    attach_gbuffer();
  } catch (...) {
    width_ = height_ = 0;
    throw;
  }
}

void RasterTargets::clear_gbuffer() const {
  const float zeros[4] = {};
  const GLuint no_ids[4] = {};
  for (uint32_t i = 0; i < floating_targets; ++i) gl_.ClearBufferfv(GL_COLOR, static_cast<GLint>(i), zeros);
  gl_.ClearBufferuiv(GL_COLOR, static_cast<GLint>(floating_targets), no_ids);
  for (uint32_t i = 0; i < lobe::count; ++i)
    if (lobe_textures_[i]) gl_.ClearBufferfv(GL_COLOR, static_cast<GLint>(floating_targets + 1 + i), zeros);
}

void RasterTargets::copy_depth() {
  if (!depth_copy_) {
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    depth_copy_ = make_texture(GL_DEPTH32F_STENCIL8, GL_DEPTH_STENCIL, GL_FLOAT_32_UNSIGNED_INT_24_8_REV);
    check_allocation(gl_, "copy of the depth");
    depth_copy_frame_ = Framebuffer(gl_);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, depth_copy_frame_.id());
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, depth_copy_.id(), 0);
    gl_.DrawBuffer(GL_NONE);
    gl_.ReadBuffer(GL_NONE);
    check_complete("copy of the depth");
  }
  const auto w = static_cast<GLint>(width_), h = static_cast<GLint>(height_);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, frame_.id());
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, depth_copy_frame_.id());
  gl_.BlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  bind_frame();
}

void RasterTargets::bind_rest() {
  if (!rest_) {
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    rest_ = make_texture(GL_RGBA32F, GL_RGBA, GL_FLOAT);
    check_allocation(gl_, "rest poses");
    rest_frame_ = Framebuffer(gl_);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, rest_frame_.id());
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, rest_.id(), 0);
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, depth_stencil_.id(), 0);
    check_complete("rest poses");
  }
  bind(rest_frame_);
  const float zeros[4] = {};
  gl_.ClearBufferfv(GL_COLOR, 0, zeros);
}

void RasterTargets::bind_motion(bool with_depth) {
  if (!motion_) {
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    motion_ = make_texture(GL_RG32F, GL_RG, GL_FLOAT);
    check_allocation(gl_, "motion");
    for (Framebuffer* framebuffer : {&motion_screen_, &motion_frame_}) {
      *framebuffer = Framebuffer(gl_);
      gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer->id());
      gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, motion_.id(), 0);
      if (framebuffer == &motion_frame_)
        gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, depth_stencil_.id(), 0);
      check_complete("motion");
    }
  }
  bind(with_depth ? motion_frame_ : motion_screen_);
}

void RasterTargets::resize(uint32_t width, uint32_t height) {
  if (width == width_ && height == height_) return;
  GLint texture_side = 0, viewport[2] = {};
  gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &texture_side);
  gl_.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  const auto most_x = static_cast<uint32_t>(std::min(texture_side, viewport[0]));
  const auto most_y = static_cast<uint32_t>(std::min(texture_side, viewport[1]));
  if (width == 0 || height == 0 || width > most_x || height > most_y)
    fail(SIDERAY_INVALID_ARGUMENT, "picture of {}x{}: {} draws 1x1 to {}x{}", width, height, gl_.renderer, most_x,
         most_y);
  width_ = width, height_ = height;
  try {
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (uint32_t i = 0; i < floating_targets; ++i) gbuffer_textures_[i] = make_texture(GL_RGBA16F, GL_RGBA, GL_FLOAT);
    allocate_ids();
    depth_stencil_ = make_texture(GL_DEPTH32F_STENCIL8, GL_DEPTH_STENCIL, GL_FLOAT_32_UNSIGNED_INT_24_8_REV);
    color_ = make_texture(GL_RGBA32F, GL_RGBA, GL_FLOAT);
    allocate_lobes();
    depth_copy_ = Texture();
    rest_ = Texture();
    motion_ = Texture();
    check_allocation(gl_, "picture");
    attach();
  } catch (...) {
    width_ = height_ = 0;
    throw;
  }
}

void RasterTargets::bind(const Framebuffer& framebuffer) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  gl_.Viewport(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
}

void RasterTargets::begin_read(const Framebuffer& framebuffer, uint32_t read_buffer) const {
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.id());
  gl_.ReadBuffer(read_buffer);
  gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.PixelStorei(GL_PACK_ROW_LENGTH, 0);
  gl_.PixelStorei(GL_PACK_SKIP_ROWS, 0);
  gl_.PixelStorei(GL_PACK_SKIP_PIXELS, 0);
}

template <typename T>
std::vector<T> RasterTargets::read(uint32_t format, uint32_t type) const {
  std::vector<T> texels(size_t{width_} * height_);
  gl_.ReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), format, type, texels.data());
  return texels;
}

std::vector<glm::vec2> RasterTargets::read_motion() const {
  begin_read(motion_screen_, GL_COLOR_ATTACHMENT0);
  return read<glm::vec2>(GL_RG, GL_FLOAT);
}

std::vector<glm::vec4> RasterTargets::read_color() const {
  begin_read(resolve_, GL_COLOR_ATTACHMENT0);
  return read<glm::vec4>(GL_RGBA, GL_FLOAT);
}

std::vector<float> RasterTargets::read_depth() const {
  begin_read(frame_, GL_COLOR_ATTACHMENT0);
  return read<float>(GL_DEPTH_COMPONENT, GL_FLOAT);
}

std::vector<uint8_t> RasterTargets::read_stencil() const {
  begin_read(frame_, GL_COLOR_ATTACHMENT0);
  return read<uint8_t>(GL_STENCIL_INDEX, GL_UNSIGNED_BYTE);
}

std::vector<glm::vec4> RasterTargets::read_gbuffer(uint32_t target) const {
  begin_read(gbuffer_, GL_COLOR_ATTACHMENT0 + target);
  return read<glm::vec4>(GL_RGBA, GL_FLOAT);
}

std::vector<glm::uvec2> RasterTargets::read_ids() const {
  begin_read(gbuffer_, GL_COLOR_ATTACHMENT0 + floating_targets);
  return read<glm::uvec2>(GL_RG_INTEGER, GL_UNSIGNED_INT);
}

}  // namespace sideray::gl
