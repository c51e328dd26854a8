// What the layer tracer asks for the light that leaves surfaces: batches of points in, radiance out. Implementations
// hold scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "rt/surface.h"

namespace sideray::rt {

class PointShader {
 public:
  virtual ~PointShader() = default;

  // Independent estimates that shade() makes of each radiance.
  virtual uint32_t estimates() const { return 1; }

  // radiance[i * estimates() + e] = C of dst = C * cover + dst * through at points[i]. Neighbouring points should come
  // from neighbouring pixels: their rays travel in packets.
  virtual void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;

  // The same of opaque surfaces that a bent ray ends at: direct light and the environment, no further bounce.
  virtual void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;

  // Traversals started since the shader began; a reflection that looks for translucent surfaces too starts two.
  uint64_t rays_reflection = 0, rays_shadow = 0;
};

}  // namespace sideray::rt
