// Provides the framebuffer to read depth and stencil from: the host's, one of our own around its image, or a copy of
// one sample of each pixel. GL thread; reused from frame to frame.
#pragma once

#include <sideray/sideray.h>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/state_guard.h"

namespace sideray::bridge {

class ReadTarget {
 public:
  // Holds the framebuffer bound for reading, and the origin of the source's rectangle in it.
  struct Bound {
    uint32_t framebuffer;  // 0: the default one
    int32_t x, y;
    bool multisampled;  // the framebuffer is a copy of one sample per pixel, anywhere in the pixel
  };
  // Binds the framebuffer. Needs a guard over framebuffers. Throws Failure (INVALID_ARGUMENT, UNSUPPORTED).
  Bound bind(const gl::Functions& gl, const sideray_frame_source& source, gl::StatePolicy policy);
  void abandon();

 private:
  uint32_t wrap_image(const gl::Functions& gl, const sideray_frame_source& source);
  void resolve(const gl::Functions& gl, uint32_t framebuffer, const sideray_frame_source& source,
               gl::StatePolicy policy);
  void allocate_copy(const gl::Functions& gl, uint32_t format, int32_t width, int32_t height);

  gl::Framebuffer around_, copy_;
  gl::Renderbuffer copied_;
  uint32_t format_ = 0;
  int32_t width_ = 0, height_ = 0;
};

}  // namespace sideray::bridge
