// Holds the targets of the distortion pass: offsets, and a copy of the opaque picture. Nothing is allocated until a
// surface distorts. The context must be current.
#pragma once

#include <cstdint>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/targets/raster_targets.h"

namespace sideray::gl {

class DistortionTargets {
 public:
  explicit DistortionTargets(const Functions& gl) : gl_(gl) {}

  // Allocates for `targets`, whose depth and stencil the offsets are drawn against. Throws Failure (OUT_OF_MEMORY,
  // GL_FAILED, UNSUPPORTED); then nothing is allocated.
  void fit(const RasterTargets& targets);
  void release();

  void bind_offsets() const;               // for drawing; sets their viewport
  void copy(const RasterTargets& source);  // copies the colour of `source`
  uint32_t offsets() const { return offsets_.id(); }
  uint32_t picture() const { return picture_.id(); }

 private:
  Texture make_texture() const;

  const Functions& gl_;
  uint32_t width_ = 0, height_ = 0, depth_stencil_ = 0;
  Texture offsets_, picture_;
  Framebuffer framebuffer_;
};

}  // namespace sideray::gl
