// Depth of 24 bits and stencil, packed by a compute shader into a buffer: the words that glReadPixels writes as
// GL_UNSIGNED_INT_24_8. Some drivers take several times as long for them (ADR 41). GL thread; one for all frames of a
// context.
#pragma once

#include <cstdint>

#include "bridge/transport/texture_upload.h"
#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"

namespace sideray::bridge {

class DepthPacker {
 public:
  // Needs `compute`. Throws Failure (GL_FAILED).
  explicit DepthPacker(const gl::Functions& gl);

  // Whether each depth comes back as the integer that it is. Drivers are free to round on the way to a shader: Mesa's
  // llvmpipe is a step off for a third of them. Looks at 65,536 depths, and waits for the GPU. Needs a guard over the
  // pixel transfer state and framebuffers, and puts everything else back, as pack() does, under either state policy:
  // what a submit touches is a promise to engines that restore their state themselves.
  bool is_exact();
  bool holds(uint64_t bytes) const { return bytes <= static_cast<uint64_t>(gl_.storage_block_bytes); }
  // Issues the packing of a rectangle of the framebuffer bound for reading, of one sample a pixel and this format, into
  // the buffer, row by row. Needs a guard over framebuffers.
  void pack(Rectangle where, uint32_t buffer);
  void abandon();

 private:
  void require_copy(uint32_t width, uint32_t height);
  void dispatch(uint32_t width, uint32_t height, uint32_t buffer);

  const gl::Functions& gl_;
  gl::Program program_;
  // Shaders cannot sample renderbuffers and windows, and a texture of the host's would need its state changed.
  gl::Texture depth_, stencil_;  // the same texels: each view shows one part
  gl::Framebuffer copy_;
  uint32_t width_ = 0, height_ = 0;
};

}  // namespace sideray::bridge
