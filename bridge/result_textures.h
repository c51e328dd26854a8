// The textures that hold a traced frame, updated tile by tile. GL thread.
#pragma once

#include <cstdint>
#include <vector>

#include "gl/functions.h"
#include "gl/objects.h"
#include "rt/tracer.h"

namespace sideray::bridge {

// Calls need a state guard over the pixel transfer state and the binding of `unit`'s texture targets.
class CacheTextures {
 public:
  // Uploads the dirty tiles (all of them after a change of size). Returns the bytes moved.
  uint64_t upload(const gl::Functions& gl, const rt::LayerCache& cache);
  // The next upload moves everything.
  void invalidate() { width_ = height_ = 0; }
  void abandon();
  uint64_t bytes() const { return bytes_; }
  uint32_t radiance() const { return radiance_.id(); }
  uint32_t distance() const { return distance_.id(); }
  uint32_t surface_id() const { return surface_id_.id(); }

 private:
  gl::Texture radiance_, distance_, surface_id_;
  uint32_t width_ = 0, height_ = 0, layers_ = 0;
  uint64_t bytes_ = 0;
};

class CompositeTextures {
 public:
  uint64_t upload(const gl::Functions& gl, const rt::CompositeImage& image);
  // The next upload moves everything.
  void invalidate() { width_ = height_ = 0; }
  void abandon();
  uint64_t bytes() const { return bytes_; }
  uint32_t radiance() const { return radiance_.id(); }
  uint32_t transmittance() const { return transmittance_.id(); }

 private:
  gl::Texture radiance_, transmittance_;
  uint32_t width_ = 0, height_ = 0;
  uint64_t bytes_ = 0;
};

}  // namespace sideray::bridge
