#include "gl/targets/order_targets.h"

#include "gl/resources/raster_textures.h"

namespace sideray::gl {

PeelSlices::PeelSlices(const Functions& gl, const RasterTargets& targets)
    : gl_(gl), targets_(targets), width_(targets.width()), height_(targets.height()) {
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  for (Slice& slice : slices_) {
    slice = {targets.make_texture(GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT),
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
  }
  check_allocation(gl, "depth peeling");
}

bool PeelSlices::fits() const {
  return width_ == targets_.width() && height_ == targets_.height();
}

void PeelSlices::begin(uint32_t slice) const {
  targets_.bind(slices_[slice].written);
  constexpr GLuint no_key[4] = {};
  gl_.ClearBufferuiv(GL_COLOR, 0, no_key);
}

void PeelSlices::bind_picture(uint32_t slice) const {
  targets_.bind(slices_[slice].picture);
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
