// Holds the rasterizer's targets (G-buffer, depth-stencil, colour) and reads them back. The context must be current.
#pragma once

#include <cstdint>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/raster_programs.h"

namespace sideray::gl {

class RasterTargets {
 public:
  explicit RasterTargets(const Functions& gl) : gl_(gl) {}

  // Throws Failure (INVALID_ARGUMENT, OUT_OF_MEMORY, GL_FAILED); then there are no targets.
  void resize(uint32_t width, uint32_t height);
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }

  // Binds all targets of the G-buffer, with depth and stencil.
  void bind_gbuffer() const { bind(gbuffer_); }
  // Binds colour alone, so that depth can be sampled.
  void bind_resolve() const { bind(resolve_); }
  // Binds colour with depth and stencil.
  void bind_frame() const { bind(frame_); }
  uint32_t frame() const { return frame_.id(); }

  // Target 4 of the G-buffer holds ids and, with lobe::anisotropy, its direction and strength; targets from 5 on hold
  // lobe::coat, sheen and behind.
  static constexpr uint32_t floating_targets = 4;
  uint32_t gbuffer_texture(uint32_t target) const { return gbuffer_textures_[target].id(); }
  // Allocates the targets of `lobes` and frees those of other lobes. Throws as resize does.
  void set_lobes(uint32_t lobes);
  uint32_t lobe_texture(uint32_t index) const { return lobe_textures_[index] ? lobe_textures_[index].id() : 0; }
  void clear_gbuffer() const;
  uint32_t depth_stencil() const { return depth_stencil_.id(); }
  uint32_t color() const { return color_.id(); }

  // Returns a new texture of the frame's size.
  Texture make_texture(uint32_t internal_format, uint32_t format, uint32_t type) const;
  // Throws Failure (GL_FAILED) where the bound framebuffer is not complete.
  void check_complete(const char* what) const;
  void bind(const Framebuffer& framebuffer) const;

  // Copies the current depth into a texture that may be read while the frame is drawn; allocated at its first use.
  void copy_depth();
  uint32_t depth_copy() const { return depth_copy_.id(); }

  // Binds and clears the target of rest positions, where rays hit what is drawn, with the frame's depth and stencil;
  // allocated at its first use.
  void bind_rest();
  uint32_t rest() const { return rest_.id(); }

  // Binds the target of motion vectors, with or without the frame's depth; allocated at its first use.
  void bind_motion(bool with_depth);
  uint32_t motion() const { return motion_.id(); }
  std::vector<glm::vec2> read_motion() const;

  std::vector<glm::vec4> read_color() const;
  std::vector<float> read_depth() const;
  std::vector<uint8_t> read_stencil() const;
  std::vector<glm::vec4> read_gbuffer(uint32_t target) const;
  std::vector<glm::uvec2> read_ids() const;

 private:
  void allocate_lobes();
  void allocate_ids();
  void attach_gbuffer();
  void attach();
  void begin_read(const Framebuffer& framebuffer, uint32_t read_buffer) const;
  template <typename T>
  std::vector<T> read(uint32_t format, uint32_t type) const;

  const Functions& gl_;
  uint32_t width_ = 0, height_ = 0;
  uint32_t lobes_ = 0;
  Texture gbuffer_textures_[floating_targets + 1], lobe_textures_[lobe::count], depth_stencil_, color_, depth_copy_,
      rest_, motion_;
  Framebuffer gbuffer_, resolve_, frame_, depth_copy_frame_, rest_frame_, motion_frame_, motion_screen_;
};

}  // namespace sideray::gl
