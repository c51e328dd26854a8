// Holds what the orders of translucent fragments draw into beside the picture; each is there only while its order is
// used. The thread whose context is current calls it; targets and functions must outlive the objects.
#pragma once

#include <cstdint>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/targets/raster_targets.h"

namespace sideray::gl {

// Holds slices of depth peeling: for one fragment a pixel the key (shaders/translucent/raster_order_key.glsl) and the
// depth.
class PeelSlices {
 public:
  PeelSlices(const Functions& gl, const RasterTargets& targets, uint32_t count);
  bool fits(uint32_t count) const;

  uint32_t count() const { return static_cast<uint32_t>(slices_.size()); }
  uint32_t keys(uint32_t slice) const { return slices_[slice].keys.id(); }
  // Binds a slice's keys and depth to be written; the keys are set to `no_key`.
  void begin(uint32_t slice, uint32_t no_key) const;
  void copy_frame_depth(uint32_t slice) const;  // after begin()
  // Binds the picture, with the slice's depth.
  void bind_picture(uint32_t slice) const;

 private:
  struct Slice {
    Texture keys, depth;
    Framebuffer written, picture;
  };
  const Functions& gl_;
  const RasterTargets& targets_;
  uint32_t width_, height_;
  std::vector<Slice> slices_;
};

// Holds sums of weighted blending. They are single floats: halves overflow to black (weights times radiance) and round
// thin covers away (1 - transmittance).
class WeightedSums {
 public:
  WeightedSums(const Functions& gl, const RasterTargets& targets);
  bool fits() const;

  // Binds and clears them, with the frame's depth.
  void begin() const;
  // Calls `draw` with each fragment's sums added and its transmittance multiplied: at once, or one after the other
  // where the driver has one blend function for all targets (before OpenGL 4.0).
  template <typename Draw>
  void blend(const Draw& draw) const {
    const int passes = gl_.blend_per_buffer ? 1 : 2;
    for (int pass = 0; pass < passes; ++pass) {
      begin_blending(pass);
      draw();
    }
  }
  uint32_t texture(uint32_t target) const { return textures_[target].id(); }
  static constexpr uint32_t sum = 0, through = 1, glow = 2, count = 3;

 private:
  void begin_blending(int pass) const;

  const Functions& gl_;
  const RasterTargets& targets_;
  uint32_t width_, height_;
  Texture textures_[count];
  Framebuffer framebuffer_;
};

// Holds lists of fragments in storage buffers: shaders/translucent/raster_order_lists.glsl.
class FragmentLists {
 public:
  explicit FragmentLists(const Functions& gl);

  static constexpr uint64_t node_bytes = 36;
  // Starts empty lists for `pixels` pixels, with room for as many nodes as before.
  void begin(uint32_t pixels);
  uint32_t capacity() const { return capacity_; }
  // Returns how many nodes were requested since begin(); it waits for what was drawn.
  uint32_t wanted() const;
  // Makes room for `capacity` nodes. Throws Failure (OUT_OF_MEMORY).
  void grow(uint32_t capacity);

 private:
  const Functions& gl_;
  Buffer heads_, nodes_;
  uint32_t pixels_ = 0, capacity_ = 0;
};

}  // namespace sideray::gl
