// Brings one frame's depth, stencil and mask of layers from a framebuffer into memory, in the buffer's own format. GL
// thread.
#pragma once

#include <sideray/sideray.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "bridge/transport/depth_packer.h"
#include "bridge/transport/read_target.h"
#include "bridge/transport/texture_readback.h"
#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/state_guard.h"
#include "rt/base/view.h"

namespace sideray::bridge {

struct DepthStencilFormat {
  rt::DepthFormat layout;
  uint32_t gl_format, gl_type, texel_bytes;
  bool has_stencil;
  int depth_bits;
};

// What the framebuffer holds that is bound for reading and for drawing. Throws Failure (UNSUPPORTED) naming the format
// and the remedy.
DepthStencilFormat depth_stencil_format(const gl::Functions& gl, bool default_framebuffer);

// The part of the framebuffer that the view covers.
Rectangle rectangle_of(const sideray_frame_source& source);

struct ReadbackRequest {
  const sideray_frame_source& source;
  gl::StatePolicy policy;
  bool stencil;                   // it is needed
  bool persistent;                // into a buffer that stays mapped, which needs buffer_storage
  DepthPacker* packer = nullptr;  // of depth with 24 bits and stencil; null: the driver packs it too
};

// A pixel buffer and its fence; reused from frame to frame.
class Readback {
 public:
  // Issues the copy of the source's rectangle and returns. Needs guards over the pixel transfer state and framebuffers.
  void start(const gl::Functions& gl, const ReadbackRequest& request);
  // Call when all copies of the frame are issued.
  void issue_fence(const gl::Functions& gl) { fence_ = gl::Fence(gl); }
  // True once the bytes can be mapped without waiting; waits at most `timeout_ns` for it.
  bool ready(uint64_t timeout_ns) const;
  // The bytes; valid until finish. Blocks where they are not ready.
  rt::DepthImage map(const gl::Functions& gl);
  // A byte a pixel where the source has such a mask, otherwise empty; valid as long.
  std::span<const uint8_t> mask() const {
    return mask_memory_.empty() ? mask_.texels<uint8_t>() : std::span<const uint8_t>(mask_memory_);
  }
  void finish(const gl::Functions& gl);
  void abandon();
  uint64_t bytes() const { return bytes_ + mask_.bytes(); }
  // Whether depth is that of one sample of each pixel, of several, once start() has returned.
  bool multisampled() const { return multisampled_; }

 private:
  void require_buffer(const gl::Functions& gl, bool persistent);
  void start_depth(const gl::Functions& gl, const ReadbackRequest& request, const ReadTarget::Bound& target);
  void start_mask(const gl::Functions& gl, const sideray_frame_source& source, Rectangle where);

  gl::Buffer buffer_;
  ReadTarget target_;
  TextureReadback mask_;
  std::vector<uint8_t> mask_memory_;
  gl::Fence fence_;
  DepthStencilFormat format_{};
  uint64_t bytes_ = 0, capacity_ = 0;
  uint32_t width_ = 0;
  bool mapped_ = false, persistent_ = false, multisampled_ = false;
  const std::byte* always_mapped_ = nullptr;  // where it is persistent
};

}  // namespace sideray::bridge
