#include "gl/targets/temporal_targets.h"

#include "gl/resources/raster_textures.h"

namespace sideray::gl {

void TemporalTargets::fit(const RasterTargets& targets) {
  if (width_ == targets.width() && height_ == targets.height()) return;
  release();
  try {
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (int i = 0; i < 2; ++i) {
      states_[i] = targets.make_texture(GL_RG32F, GL_RG, GL_FLOAT);
      pictures_[i] = targets.make_texture(GL_RGBA16F, GL_RGBA, GL_FLOAT);
      gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
      gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
      framebuffers_[i] = Framebuffer(gl_);
      gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[i].id());
      gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, pictures_[i].id(), 0);
      gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, states_[i].id(), 0);
      const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
      gl_.DrawBuffers(2, both);
      targets.check_complete("temporal");
    }
    check_allocation(gl_, "temporal anti-aliasing");
  } catch (...) {
    release();
    throw;
  }
  width_ = targets.width(), height_ = targets.height();
}

void TemporalTargets::release() {
  for (int i = 0; i < 2; ++i) pictures_[i].reset(), states_[i].reset(), framebuffers_[i].reset();
  width_ = height_ = 0;
  has_past_ = false;
}

void TemporalTargets::replace(const std::vector<glm::vec4>& picture) {
  constexpr float as_many = 16.0f;  // more pictures than the average ever counts
  constexpr float largest_half = 65504.0f;
  std::vector<glm::vec4> halfs = picture;
  for (glm::vec4& c : halfs) c = glm::min(c, largest_half);  // no infinities: they would never fade
  gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl_.BindTexture(GL_TEXTURE_2D, pictures_[1 - made_].id());
  gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), GL_RGBA, GL_FLOAT,
                    halfs.data());
  least_pictures_ = as_many;
}

void TemporalTargets::copy_to(const RasterTargets& targets) const {
  const auto w = static_cast<GLint>(width_), h = static_cast<GLint>(height_);
  targets.bind_resolve();
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[made_].id());
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.BlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

}  // namespace sideray::gl
