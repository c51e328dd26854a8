// Saves a group of OpenGL state and restores it exactly at the end of the guard's scope, so that a call inside a host's
// frame leaves no trace. One thread constructs and destroys each guard, with the context current. State that the
// context does not have is skipped. If another context deleted a name meanwhile, 0 is bound instead, without an OpenGL
// error. Under StatePolicy::leave nothing is read, and at the end of the scope the covered state has its initial value,
// except for viewports and scissor boxes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gl/context/functions.h"

namespace sideray::gl {

enum class StatePolicy : uint8_t { restore, leave };

// Guards the bindings of read and draw framebuffer and renderbuffer, but not a framebuffer's own draw and read buffers.
class FramebufferGuard {
 public:
  explicit FramebufferGuard(const Functions& gl, StatePolicy policy = StatePolicy::restore);
  ~FramebufferGuard();
  FramebufferGuard(const FramebufferGuard&) = delete;
  FramebufferGuard& operator=(const FramebufferGuard&) = delete;

 private:
  const Functions& gl_;
  uint32_t read_ = 0, draw_ = 0, renderbuffer_ = 0;
};

// Guards everything that changes pixels in transfers: pixel buffers, pixel store, colour clamping of reads, and in
// compatibility contexts glPixelTransfer. In its scope all of it has the initial values: rows aligned to 4 bytes and
// otherwise tightly packed, client memory, no scale, bias or maps.
class PixelTransferGuard {
 public:
  explicit PixelTransferGuard(const Functions& gl, StatePolicy policy = StatePolicy::restore);
  ~PixelTransferGuard();
  PixelTransferGuard(const PixelTransferGuard&) = delete;
  PixelTransferGuard& operator=(const PixelTransferGuard&) = delete;

 private:
  static constexpr size_t store_count = 16, scale_count = 10, map_count = 4;
  void save();
  void neutralize() const;
  const Functions& gl_;
  const StatePolicy policy_;
  uint32_t pack_buffer_ = 0, unpack_buffer_ = 0;
  int32_t clamp_read_ = 0;
  std::array<int32_t, store_count> store_{};
  std::array<float, scale_count> transfer_{};  // compatibility contexts only, like the next
  std::array<int32_t, map_count> transfer_maps_{};
};

// Guards the active unit and, for units [first, first + count), the 2D and 2D array textures and the sampler object.
class TextureGuard {
 public:
  TextureGuard(const Functions& gl, uint32_t first_unit, uint32_t count, StatePolicy policy = StatePolicy::restore);
  ~TextureGuard();
  TextureGuard(const TextureGuard&) = delete;
  TextureGuard& operator=(const TextureGuard&) = delete;

 private:
  struct Unit {
    uint32_t texture_2d = 0, texture_2d_array = 0, sampler = 0;
  };
  const Functions& gl_;
  uint32_t first_unit_, active_ = 0;
  std::vector<Unit> units_;
};

// Holds the range that is bound to an indexed binding point.
struct BufferRange {
  uint32_t buffer = 0;
  int64_t start = 0, size = 0;  // size 0: the whole buffer
};

// Guards the array, copy read, copy write and uniform buffer bindings, and the indexed uniform bindings [0,
// indexed_count).
class BufferGuard {
 public:
  explicit BufferGuard(const Functions& gl, uint32_t indexed_count = 0);
  ~BufferGuard();
  BufferGuard(const BufferGuard&) = delete;
  BufferGuard& operator=(const BufferGuard&) = delete;

 private:
  const Functions& gl_;
  std::array<uint32_t, 4> generic_{};
  std::vector<BufferRange> indexed_;
};

// Guards the shader storage buffer and its indexed points [0, indexed_count). Needs storage_buffers.
class StorageGuard {
 public:
  StorageGuard(const Functions& gl, uint32_t indexed_count, StatePolicy policy = StatePolicy::restore);
  ~StorageGuard();
  StorageGuard(const StorageGuard&) = delete;
  StorageGuard& operator=(const StorageGuard&) = delete;

 private:
  const Functions& gl_;
  uint32_t generic_ = 0;
  std::vector<BufferRange> indexed_;
};

// Guards only the program in use, for setting uniforms.
class ProgramGuard {
 public:
  explicit ProgramGuard(const Functions& gl, StatePolicy policy = StatePolicy::restore);
  ~ProgramGuard();
  ProgramGuard(const ProgramGuard&) = delete;
  ProgramGuard& operator=(const ProgramGuard&) = delete;

 private:
  const Functions& gl_;
  uint32_t program_ = 0;
};

// Guards the state that a full-screen pass depends on: program, vertex array, viewports and scissors, and the
// fixed-function state of rasterization, depth, blending and colour mask. In its scope the program and vertex array are
// still the host's; the fixed-function state has the initial values, so that a pass sets only what differs. The stencil
// test is off; a pass that uses it, or clears stencil, takes a StencilGuard too.
class DrawGuard {
 public:
  explicit DrawGuard(const Functions& gl, StatePolicy policy = StatePolicy::restore);
  ~DrawGuard();
  DrawGuard(const DrawGuard&) = delete;
  DrawGuard& operator=(const DrawGuard&) = delete;

 private:
  struct Blend {
    bool enabled = false;
    std::array<uint32_t, 2> equation{};  // rgb, alpha
    std::array<uint32_t, 4> factors{};   // source rgb, destination rgb, source alpha, destination alpha
    std::array<uint8_t, 4> color_mask{};
  };
  struct Window {
    std::array<float, 4> viewport{};
    std::array<int32_t, 4> scissor{};
    bool scissor_test = false;
  };
  void save_windows();
  void save_fragment_tests();
  void neutralize() const;
  void restore_windows() const;
  void restore_fragment_tests() const;
  // Returns whether the context can clamp fragment outputs to 0..1, even in float targets: compatibility contexts only.
  bool clamps_fragments() const { return !gl_.core_profile && gl_.clamp_read_color; }

  const Functions& gl_;
  const StatePolicy policy_;
  ProgramGuard program_;
  uint32_t vertex_array_ = 0;
  std::vector<bool> capabilities_;
  std::vector<Window> windows_;
  std::vector<Blend> blends_;
  uint32_t depth_function_ = 0;
  bool depth_mask_ = true;
  std::array<uint32_t, 2> polygon_mode_{};
  std::array<uint32_t, 2> clip_control_{};
  std::array<float, 4> blend_color_{};
  uint32_t clamp_fragment_ = 0;
};

// Guards stencil functions, operations and masks, but not the test itself; in its scope they have the initial values. A
// framebuffer with a stencil buffer must be bound already: drivers return the reference value clamped to the bits of
// the bound one.
class StencilGuard {
 public:
  explicit StencilGuard(const Functions& gl);
  ~StencilGuard();
  StencilGuard(const StencilGuard&) = delete;
  StencilGuard& operator=(const StencilGuard&) = delete;

 private:
  struct StencilFace {
    uint32_t function = 0, reference = 0, value_mask = 0, write_mask = 0;
    std::array<uint32_t, 3> operations{};
  };
  const Functions& gl_;
  std::array<StencilFace, 2> faces_{};
};

}  // namespace sideray::gl
