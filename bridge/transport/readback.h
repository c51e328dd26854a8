// Reads one frame's depth, stencil and mask of layers from a framebuffer into memory, in the framebuffer's own format.
// GL thread.
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

// Returns the format of the framebuffer that is bound for reading and drawing. Throws Failure (UNSUPPORTED) that names
// the format and the remedy.
DepthStencilFormat depth_stencil_format(const gl::Functions& gl, bool default_framebuffer);

// Returns the part of the framebuffer that the view covers.
Rectangle rectangle_of(const sideray_frame_source& source);

struct ReadbackRequest {
  const sideray_frame_source& source;
  gl::StatePolicy policy;
  bool stencil;                   // stencil is needed
  bool persistent;                // uses a buffer that stays mapped, which needs buffer_storage
  DepthPacker* packer = nullptr;  // packs depth of 24 bits with stencil; null: the driver does
};

// Holds a pixel buffer and its fence; reused from frame to frame.
class Readback {
 public:
  // Issues the copy of the source's rectangle and returns. Needs guards over the pixel transfer state and framebuffers.
  void start(const gl::Functions& gl, const ReadbackRequest& request);
  // Call it once all copies of the frame are issued.
  void issue_fence(const gl::Functions& gl) { fence_ = gl::Fence(gl); }
  // Returns whether the bytes can be mapped without waiting; waits at most `timeout_ns` for it.
  bool ready(uint64_t timeout_ns) const;
  // Returns the bytes, valid until finish(). Blocks where they are not ready.
  rt::DepthImage map(const gl::Functions& gl);
  // Returns a byte per pixel where the source has such a mask, otherwise nothing; valid as long.
  std::span<const uint8_t> mask() const {
    return mask_memory_.empty() ? mask_.texels<uint8_t>() : std::span<const uint8_t>(mask_memory_);
  }
  void finish(const gl::Functions& gl);
  void abandon();
  uint64_t bytes() const { return bytes_ + mask_.bytes(); }
  // Returns whether depth comes from one of several samples per pixel; valid after start().
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
  const std::byte* always_mapped_ = nullptr;  // only where persistent_
};

}  // namespace sideray::bridge
