#include "bridge/transport/readback.h"

#include <algorithm>

#include "model/failure.h"

namespace sideray::bridge {
namespace {

[[noreturn]] void fail_to_map(uint64_t bytes) {
  fail(SIDERAY_OUT_OF_MEMORY, "depth readback: the driver could not map {} bytes; lower the resolution", bytes);
}

struct Bits {
  int depth, stencil;
  bool float_depth;
};

// Queries the whole framebuffer, as before OpenGL 3.0 there was no other way; 32 bits were floats then.
Bits bits_of_framebuffer(const gl::Functions& gl) {
  Bits bits{};
  gl.GetIntegerv(GL_DEPTH_BITS, &bits.depth);
  gl.GetIntegerv(GL_STENCIL_BITS, &bits.stencil);
  return bits;
}

Bits bits_of_attachments(const gl::Functions& gl, bool default_framebuffer) {
  const GLenum depth = default_framebuffer ? GL_DEPTH : GL_DEPTH_ATTACHMENT;
  const GLenum stencil = default_framebuffer ? GL_STENCIL : GL_STENCIL_ATTACHMENT;
  const auto parameter = [&](GLenum attachment, GLenum name) {
    int value = 0;
    gl.GetFramebufferAttachmentParameteriv(gl.read_framebuffer, attachment, name, &value);
    return value;
  };
  const auto is_there = [&](GLenum attachment) {
    return parameter(attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) != GL_NONE;
  };
  Bits bits{};
  if (!is_there(depth)) return bits;
  bits.depth = parameter(depth, GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE);
  bits.float_depth = parameter(depth, GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE) == GL_FLOAT;
  if (is_there(stencil)) bits.stencil = parameter(stencil, GL_FRAMEBUFFER_ATTACHMENT_STENCIL_SIZE);
  return bits;
}

}  // namespace

Rectangle rectangle_of(const sideray_frame_source& source) {
  return {static_cast<uint32_t>(source.x), static_cast<uint32_t>(source.y), static_cast<uint32_t>(source.width),
          static_cast<uint32_t>(source.height)};
}

DepthStencilFormat depth_stencil_format(const gl::Functions& gl, bool default_framebuffer) {
  const Bits bits = gl.attachment_sizes ? bits_of_attachments(gl, default_framebuffer) : bits_of_framebuffer(gl);
  if (bits.depth == 0)
    fail(SIDERAY_UNSUPPORTED,
         "framebuffer: it has no depth attachment; attach the depth buffer that the opaque pass wrote");
  const bool has_stencil = bits.stencil > 0;
  if (has_stencil && (bits.float_depth || bits.depth == 32))
    return {rt::DepthFormat::d32f_s8, GL_DEPTH_STENCIL, GL_FLOAT_32_UNSIGNED_INT_24_8_REV, 8, true, 32};
  if (has_stencil && bits.depth == 24)
    return {rt::DepthFormat::d24s8, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, 4, true, 24};
  if (has_stencil)
    fail(SIDERAY_UNSUPPORTED, "framebuffer: {}-bit depth with stencil; use DEPTH24_STENCIL8 or DEPTH32F_STENCIL8",
         bits.depth);
  if (bits.depth == 16) return {rt::DepthFormat::d16, GL_DEPTH_COMPONENT, GL_UNSIGNED_SHORT, 2, false, 16};
  const rt::DepthFormat floats = bits.depth == 24 ? rt::DepthFormat::d24 : rt::DepthFormat::d32f;
  return {floats, GL_DEPTH_COMPONENT, GL_FLOAT, 4, false, bits.depth};
}

// Binds the buffer, and allocates it where it is too small or of the other kind.
void Readback::require_buffer(const gl::Functions& gl, bool persistent) {
  if (buffer_ && persistent == persistent_ && capacity_ >= bytes_) {
    gl.BindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
    return;
  }
  buffer_ = gl::Buffer(gl);
  persistent_ = persistent;
  capacity_ = 0;
  const auto size = static_cast<GLsizeiptr>(bytes_);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
  if (persistent) {
    constexpr GLbitfield flags = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    gl.BufferStorage(GL_PIXEL_PACK_BUFFER, size, nullptr, flags);
    always_mapped_ = static_cast<const std::byte*>(gl.MapBufferRange(GL_PIXEL_PACK_BUFFER, 0, size, flags));
    if (!always_mapped_) fail_to_map(bytes_);
  } else {
    gl.BufferData(GL_PIXEL_PACK_BUFFER, size, nullptr, GL_STREAM_READ);
  }
  capacity_ = bytes_;
}

void Readback::start(const gl::Functions& gl, const ReadbackRequest& request) {
  const sideray_frame_source& source = request.source;
  const ReadTarget::Bound target = target_.bind(gl, source, request.policy);
  multisampled_ = target.multisampled;
  format_ = depth_stencil_format(gl, target.framebuffer == 0);
  if (request.stencil && !format_.has_stencil)
    fail(
        SIDERAY_UNSUPPORTED,
        "framebuffer {}: it has no stencil, which the mask is read from; attach one or use another sideray_mask_source",
        source.framebuffer);
  width_ = static_cast<uint32_t>(source.width);
  bytes_ = uint64_t{width_} * static_cast<uint32_t>(source.height) * format_.texel_bytes;
  require_buffer(gl, request.persistent);
  start_depth(gl, request, target);
  start_mask(gl, source, rectangle_of(source));
}

void Readback::start_depth(const gl::Functions& gl, const ReadbackRequest& request, const ReadTarget::Bound& target) {
  const sideray_frame_source& source = request.source;
  if (request.packer && format_.layout == rt::DepthFormat::d24s8 && request.packer->holds(bytes_)) {
    const Rectangle all = rectangle_of(source);
    const auto x = static_cast<uint32_t>(target.x), y = static_cast<uint32_t>(target.y);
    request.packer->pack({x, y, all.width, all.height}, buffer_.id());
    return;
  }
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(target.x, target.y, source.width, source.height, format_.gl_format, format_.gl_type, nullptr);
}

void Readback::start_mask(const gl::Functions& gl, const sideray_frame_source& source, Rectangle where) {
  mask_.start(gl, "mask_texture", source.mask == SIDERAY_MASK_TEXTURE ? source.mask_texture : 0, where, red_bytes);
  mask_memory_.clear();
  if (source.mask != SIDERAY_MASK_MEMORY) return;
  mask_memory_.resize(size_t{where.width} * where.height);
  for (size_t y = 0; y < where.height; ++y)
    std::copy_n(source.mask_texels + y * source.mask_row_bytes, where.width, &mask_memory_[y * where.width]);
}

bool Readback::ready(uint64_t timeout_ns) const {
  return fence_.wait(timeout_ns);
}

rt::DepthImage Readback::map(const gl::Functions& gl) {
  mask_.map(gl);
  const rt::DepthImage image{always_mapped_, size_t{width_} * format_.texel_bytes, format_.layout};
  if (persistent_) {
    if (!fence_.wait(0)) gl.Finish();
    fence_.reset();
    return image;
  }
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
  const void* bytes = gl::map_to_read(gl, GL_PIXEL_PACK_BUFFER, bytes_);
  if (!bytes) fail_to_map(bytes_);
  mapped_ = true;
  fence_.reset();
  return {static_cast<const std::byte*>(bytes), image.row_bytes, image.format};
}

void Readback::finish(const gl::Functions& gl) {
  mask_.finish(gl);
  if (!mapped_) return;
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
  gl.UnmapBuffer(GL_PIXEL_PACK_BUFFER);
  mapped_ = false;
}

void Readback::abandon() {
  buffer_.abandon();
  mask_.abandon();
  target_.abandon();
  fence_.abandon();
  always_mapped_ = nullptr;
  capacity_ = 0;
  mapped_ = false;
}

}  // namespace sideray::bridge
