// Separates a renderer's call from a host's OpenGL state: within its scope all state that the rasterizer's passes set
// or depend on has its initial value, and at its end every bit is as the host left it. Needs the host's context, OpenGL
// 3.3 or later, current in every call, on one thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "gl/resources/error_guard.h"
#include "gl/resources/objects.h"
#include "gl/resources/state_guard.h"

namespace sideray::gl {

// Guards culling, polygon offset, depth ranges, the provoking vertex, the quality of derivatives, shader storage
// buffers [0, 2) and, in compatibility contexts, the level bias of the texture units [0, unit_count).
class RasterizationGuard {
 public:
  RasterizationGuard(const Functions& gl, uint32_t unit_count);
  ~RasterizationGuard();
  RasterizationGuard(const RasterizationGuard&) = delete;
  RasterizationGuard& operator=(const RasterizationGuard&) = delete;

 private:
  void save_level_biases(uint32_t unit_count);
  void restore_level_biases() const;

  const Functions& gl_;
  uint32_t cull_face_, front_face_, provoking_vertex_, derivative_hint_;
  bool offsets_lines_ = false, offsets_points_ = false;
  std::array<float, 3> polygon_offset_{};  // factor, units, clamp
  std::vector<std::array<double, 2>> depth_ranges_;
  uint32_t indirect_buffer_ = 0;
  std::optional<StorageGuard> storage_;
  std::vector<float> level_biases_;
};

class HostGuard {
 public:
  // `stencil_framebuffer` must have a stencil buffer, for StencilGuard.
  HostGuard(const Functions& gl, uint32_t stencil_framebuffer);

  // Takes the OpenGL errors that our calls have raised since the last time and returns the first; GL_NO_ERROR = none.
  GLenum take_error() const { return errors_.take(); }

 private:
  struct BoundFramebuffer {
    BoundFramebuffer(const Functions& gl, uint32_t framebuffer) { gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer); }
  };
  // The order matters: errors are kept apart around everything else, and the queried stencil state depends on the bound
  // framebuffer.
  ErrorGuard errors_;
  FramebufferGuard framebuffers_;
  BoundFramebuffer stencil_;
  PixelTransferGuard pixel_transfer_;
  TextureGuard textures_;
  BufferGuard buffers_;
  RasterizationGuard rasterization_;
  DrawGuard draw_;
  StencilGuard stencil_state_;
};

// Throws Failure (INVALID_ARGUMENT) where the host has something active that would count our draws or make them fail: a
// query of samples or primitives, or transform feedback.
void require_nothing_under_way(const Functions& gl);

}  // namespace sideray::gl
