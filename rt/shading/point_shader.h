// Declares the interface between tracers and shading: tracers pass batches of points and receive their outgoing light.
// Implementations have scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "rt/base/trace_end.h"
#include "rt/light/secondary_hits.h"
#include "rt/surfaces/surface.h"
#include "rt/surfaces/surface_batch.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {

// Holds the part of a point's light that rough lobes reflect or transmit, sampled in one random direction. The point's
// light contains radiance * weight; a filter may replace that by another estimate.
struct RoughReflection {
  glm::vec3 radiance;
  glm::vec3 weight;  // 0: no light here depends on a random direction
  float roughness;   // perceptual; that of the lobe that reflects most
  float nearness;    // 1 / distance of the reflected surface, mean over the ray's hits; 0 = the environment
  float spread = 1.0f;   // width of the lobe, relative to that of a reflection of this roughness
  bool through = false;  // light seen through the surface, not reflected
  // If true, `radiance` is from the one direction even if it hit nothing, and `surroundings` is the whole lobe's
  // environment. If false, a direction that hit nothing has the radiance of the whole lobe's environment.
  bool is_sampled = false;
  glm::vec3 surroundings{0.0f};
};

// Counts a shader's work since it began.
struct ShaderWork {
  // Numbers of traversals; a reflection that also looks for translucent surfaces starts two.
  uint64_t rays_reflection = 0, rays_shadow = 0, rays_bounce = 0;
  // Numbers of points that a host's shader was called for, and of its results that were not finite.
  uint64_t points_asked = 0, points_not_finite = 0;
  // Other than complete: the host's shader is no longer called, and later results are invalid.
  TraceEnd end = TraceEnd::complete;
};

class RaySharing;
class MediumStack;

class PointShader : public ShaderWork {
 public:
  virtual ~PointShader() = default;

  // Is called before points are blended and the visible ones passed to shade(). Sets SurfacePoint::answer if a host's
  // shader, not the material, decides the cover. Answers are valid until the next call.
  virtual void cover(std::span<SurfacePoint> /*points*/) {}

  // Returns how many independent estimates shade() makes of each radiance.
  virtual uint32_t estimates() const { return 1; }

  // Sets the media around the points of the next call, one entry a point; must stay valid during that call. Only
  // shaders that follow rays inside volumes use it.
  virtual void within(const MediumStack* /*media*/) {}

  // Writes radiance[i * estimates() + e] = C of dst = C * cover + dst * through at points[i]. Neighbouring points
  // should come from neighbouring pixels, because their rays form packets.
  virtual void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;

  // Writes the radiance of opaque surfaces at the end of refracted rays: direct light and environment, without further
  // bounces.
  virtual void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;
  // Returns the environment that a lobe of this roughness sees where its ray leaves the scene.
  virtual glm::vec3 surroundings(glm::vec3 direction, float roughness) const = 0;

  // Returns the interface for points that reuse rays; null if each needs its own.
  virtual RaySharing* sharing() { return nullptr; }

  // Returns the rough reflection of each point of the last shade(); empty if the shader does not separate it.
  virtual std::span<const RoughReflection> rough() const { return {}; }
};

}  // namespace sideray::rt
