#include "gl/targets/order_targets.h"

#include "gl/resources/raster_textures.h"

namespace sideray::gl {

PeelSlices::PeelSlices(const Functions& gl, const RasterTargets& targets, uint32_t count)
    : gl_(gl), targets_(targets), width_(targets.width()), height_(targets.height()) {
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  for (uint32_t i = 0; i < count; ++i) {
    Slice slice{targets.make_texture(GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT),
                targets.make_texture(GL_DEPTH32F_STENCIL8, GL_DEPTH_STENCIL, GL_FLOAT_32_UNSIGNED_INT_24_8_REV),
                Framebuffer(gl), Framebuffer(gl)};
    const uint32_t colors[] = {slice.keys.id(), targets.color()};
    const uint32_t framebuffers[] = {slice.written.id(), slice.picture.id()};
    for (int k = 0; k < 2; ++k) {
      gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffers[k]);
      gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colors[k], 0);
      gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, slice.depth.id(), 0);
      targets.check_complete("depth peeling");
    }
    slices_.push_back(std::move(slice));
  }
  check_allocation(gl, "depth peeling");
}

bool PeelSlices::fits(uint32_t wanted) const {
  return count() == wanted && width_ == targets_.width() && height_ == targets_.height();
}

void PeelSlices::begin(uint32_t slice, uint32_t no_key) const {
  targets_.bind(slices_[slice].written);
  const GLuint key[] = {no_key, no_key, 0, 0};
  gl_.ClearBufferuiv(GL_COLOR, 0, key);
}

void PeelSlices::copy_frame_depth(uint32_t slice) const {
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, targets_.frame());
  const auto w = static_cast<GLint>(width_), h = static_cast<GLint>(height_);
  gl_.BlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  targets_.bind(slices_[slice].written);
}

void PeelSlices::bind_picture(uint32_t slice) const {
  targets_.bind(slices_[slice].picture);
}

WeightedSums::WeightedSums(const Functions& gl, const RasterTargets& targets)
    : gl_(gl), targets_(targets), width_(targets.width()), height_(targets.height()), framebuffer_(gl) {
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  for (Texture& texture : textures_) texture = targets.make_texture(GL_RGBA32F, GL_RGBA, GL_FLOAT);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  for (uint32_t i = 0; i < count; ++i)
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + i, GL_TEXTURE_2D, texture(i), 0);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, targets.depth_stencil(), 0);
  targets.check_complete("weighted blending");
  check_allocation(gl, "weighted blending");
}

bool WeightedSums::fits() const {
  return width_ == targets_.width() && height_ == targets_.height();
}

void WeightedSums::begin() const {
  targets_.bind(framebuffer_);
  constexpr GLenum all[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
  gl_.DrawBuffers(count, all);
  constexpr float zeros[4] = {}, ones[4] = {1, 1, 1, 1};
  gl_.ClearBufferfv(GL_COLOR, sum, zeros);
  gl_.ClearBufferfv(GL_COLOR, through, ones);
  gl_.ClearBufferfv(GL_COLOR, glow, zeros);
  gl_.Enable(GL_BLEND);
}

void WeightedSums::begin_blending(int pass) const {
  if (gl_.blend_per_buffer) {
    gl_.BlendFunci(sum, GL_ONE, GL_ONE);
    gl_.BlendFunci(through, GL_ZERO, GL_SRC_COLOR);
    gl_.BlendFunci(glow, GL_ONE, GL_ONE);
    return;
  }
  constexpr GLenum added[] = {GL_COLOR_ATTACHMENT0, GL_NONE, GL_COLOR_ATTACHMENT2};
  constexpr GLenum multiplied[] = {GL_NONE, GL_COLOR_ATTACHMENT1, GL_NONE};
  gl_.DrawBuffers(count, pass == 0 ? added : multiplied);
  pass == 0 ? gl_.BlendFunc(GL_ONE, GL_ONE) : gl_.BlendFunc(GL_ZERO, GL_SRC_COLOR);
}

FragmentLists::FragmentLists(const Functions& gl) : gl_(gl), heads_(gl), nodes_(gl) {}

void FragmentLists::begin(uint32_t pixels) {
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, heads_.id());
  if (pixels != pixels_) {
    gl_.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>((size_t{pixels} + 1) * sizeof(uint32_t)), nullptr,
                   GL_DYNAMIC_COPY);
    check_allocation(gl_, "fragment lists");
    pixels_ = pixels;
  }
  const GLuint zero = 0;
  gl_.ClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, nodes_.id());
}

uint32_t FragmentLists::wanted() const {
  gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  GLuint used = 0;
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, heads_.id());
  gl_.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof(used), &used);
  return used;
}

void FragmentLists::grow(uint32_t capacity) {
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, nodes_.id());
  gl_.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(capacity * node_bytes), nullptr, GL_DYNAMIC_COPY);
  capacity_ = 0;
  check_allocation(gl_, "fragment lists");
  capacity_ = capacity;
}

}  // namespace sideray::gl
