// Holds a copy of the opaque picture with mip levels, for surfaces that bend or blur what is seen through them. A texel of
// a level is the level before it, sampled bilinearly at its centre. Nothing is allocated until a surface needs it. The context must be current.
#pragma once

#include <cstdint>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/targets/raster_targets.h"

namespace sideray::gl {

class OpaqueLevels {
 public:
  explicit OpaqueLevels(const Functions& gl) : gl_(gl) {}

  // Copies the colour of `source`. Throws Failure (OUT_OF_MEMORY); then there is no copy.
  void copy(const RasterTargets& source);
  void release();
  uint32_t texture() const { return texture_.id(); }

 private:
  void fit(uint32_t width, uint32_t height);
  int levels() const;
  GLsizei width_of(int level) const;
  GLsizei height_of(int level) const;
  void bind(GLenum target, const Framebuffer& framebuffer, int level) const;

  const Functions& gl_;
  uint32_t width_ = 0, height_ = 0;
  Texture texture_;
  Framebuffer finer_, coarser_;  // of two levels that follow each other
};

}  // namespace sideray::gl
