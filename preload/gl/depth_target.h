// A framebuffer with a texture of depth and one that marks pixels, which the service reads.
#pragma once

#include <array>

#include "preload/gl/functions.h"

namespace sideray::run {

class DepthTarget {
 public:
  DepthTarget() = default;
  ~DepthTarget();
  DepthTarget(const DepthTarget&) = delete;
  DepthTarget& operator=(const DepthTarget&) = delete;
  // For a context that is gone.
  void abandon() { framebuffer_ = depth_ = marks_ = 0; }

  // Makes the textures reach to the viewport's far corner. They begin at the framebuffer's first pixel.
  void make(const std::array<GLint, 4>& viewport);
  // Takes the depth of the framebuffer that is bound.
  void copy_depth();
  // Draws go here; no pixel is marked. Throws sideray::Error where the driver cannot.
  void begin();

  GLuint framebuffer() const { return framebuffer_; }
  GLuint depth() const { return depth_; }
  GLuint marks() const { return marks_; }

 private:
  GLuint framebuffer_ = 0, depth_ = 0, marks_ = 0;
  GLint width_ = 0, height_ = 0;
};

}  // namespace sideray::run
