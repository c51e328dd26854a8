// Holds a copy of the opaque picture with mip levels, for surfaces that bend or blur what is seen through them. Nothing
// is allocated until one does. The context must be current.
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

  const Functions& gl_;
  uint32_t width_ = 0, height_ = 0;
  Texture texture_;
};

}  // namespace sideray::gl
