// Packs 24-bit depth and stencil into a buffer by a compute shader, in the words that glReadPixels writes as
// GL_UNSIGNED_INT_24_8, since some drivers take several times as long for these (ADR 41). GL thread; one for all frames
// of a context.
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

  // Returns whether each depth comes back as its exact integer. Drivers may round on the way to a shader: Mesa's
  // llvmpipe is off by one step for a third of them. Tests 65,536 depths and waits for the GPU. Needs a guard over the
  // pixel transfer state and framebuffers, and restores everything else, as pack() does, under either state policy:
  // engines that restore state themselves rely on the list of state that a submit touches.
  bool is_exact();
  bool holds(uint64_t bytes) const { return bytes <= static_cast<uint64_t>(gl_.storage_block_bytes); }
  // Packs a rectangle of the framebuffer bound for reading, which has one sample per pixel and this format, into the
  // buffer, row by row. Needs a guard over framebuffers.
  void pack(Rectangle where, uint32_t buffer);
  void abandon();

 private:
  void require_copy(uint32_t width, uint32_t height);
  void dispatch(uint32_t width, uint32_t height, uint32_t buffer);

  const gl::Functions& gl_;
  gl::Program program_;
  // Shaders cannot sample renderbuffers and windows, and sampling a host's texture would change its state.
  gl::Texture depth_, stencil_;  // the same texels: each view shows one part
  gl::Framebuffer copy_;
  uint32_t width_ = 0, height_ = 0;
};

}  // namespace sideray::bridge
