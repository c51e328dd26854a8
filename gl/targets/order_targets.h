// Holds the extra targets of the orders of translucent fragments; each exists only while its order is used. The context
// must be current; targets and functions must outlive the objects.
#pragma once

#include <cstdint>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/targets/raster_targets.h"

namespace sideray::gl {

// Holds two slices of depth peeling, this step's and the one before: in each pixel the key
// (shaders/translucent/raster_order_key.glsl) and the depth of one fragment.
class PeelSlices {
 public:
  PeelSlices(const Functions& gl, const RasterTargets& targets);
  bool fits() const;

  uint32_t keys(uint32_t slice) const { return slices_[slice].keys.id(); }
  // Binds a slice's keys and depth for writing, and clears the keys to 0, behind all others.
  void begin(uint32_t slice) const;
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
  Slice slices_[2];
};

// Holds lists of fragments in storage buffers: shaders/translucent/raster_order_lists.glsl.
class FragmentLists {
 public:
  explicit FragmentLists(const Functions& gl);

  static constexpr uint64_t node_bytes = 36;
  // Starts empty lists for `pixels` pixels, with room for as many nodes as before.
  void begin(uint32_t pixels);
  uint32_t capacity() const { return capacity_; }
  // Returns how many nodes were requested since begin(); waits for the draws.
  uint32_t wanted() const;
  // Makes room for `capacity` nodes. Throws Failure (OUT_OF_MEMORY).
  void grow(uint32_t capacity);

 private:
  const Functions& gl_;
  Buffer heads_, nodes_;
  uint32_t pixels_ = 0, capacity_ = 0;
};

}  // namespace sideray::gl
