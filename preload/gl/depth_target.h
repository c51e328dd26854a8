// A framebuffer that the service reads, with a depth texture and a texture that marks pixels.
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
  // Forgets the OpenGL objects, if their context is gone.
  void abandon() { framebuffer_ = depth_ = marks_ = 0; }

  // Makes textures that reach from the framebuffer's first pixel to the viewport's far corner.
  void make(const std::array<GLint, 4>& viewport);
  // Copies the depth of the bound framebuffer.
  void copy_depth();
  // Binds the framebuffer for drawing and clears the marks. Throws sideray::Error if the driver refuses it.
  void begin();

  GLuint framebuffer() const { return framebuffer_; }
  GLuint depth() const { return depth_; }
  GLuint marks() const { return marks_; }

 private:
  GLuint framebuffer_ = 0, depth_ = 0, marks_ = 0;
  GLint width_ = 0, height_ = 0;
};

}  // namespace sideray::run
