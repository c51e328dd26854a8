// Declares the tracers' interface to shading: tracers hand in batches of points and get the light that leaves them.
// Implementations hold scratch memory: one object per thread.
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

// Holds the part of a point's light that rough lobes reflect, or let through, sampled by one random direction. radiance
// * weight is contained in the point's light; another estimate of the radiance, as a filter makes it, may take its
// place.
struct RoughReflection {
  glm::vec3 radiance;
  glm::vec3 weight;  // 0: nothing here depends on a random direction
  float roughness;   // perceptual; that of the lobe that reflects most
  float nearness;    // 1 / distance of what it reflects, averaged over what the ray hit; 0 = the environment
  float spread = 1.0f;   // width of the lobe, relative to that of a reflection of this roughness
  bool through = false;  // it is seen through the surface
  // If true, `radiance` is that of one direction also where it hit nothing, and `surroundings` is what the whole lobe
  // sees where nothing stands around. Otherwise a direction that hit nothing has all of the lobe's surroundings.
  bool is_sampled = false;
  glm::vec3 surroundings{0.0f};
};

// Counts what a shader did since it began.
struct ShaderWork {
  // These count traversals; a reflection that looks for translucent surfaces too starts two.
  uint64_t rays_reflection = 0, rays_shadow = 0, rays_bounce = 0;
  // These count points that a host's shader was called for, and its results that were not finite.
  uint64_t points_asked = 0, points_not_finite = 0;
  // Other than complete: the host's shader is not called any more, and results after that are invalid.
  TraceEnd end = TraceEnd::complete;
};

class RaySharing;
class MediumStack;

class PointShader : public ShaderWork {
 public:
  virtual ~PointShader() = default;

  // This is called before the points are blended and those that count are given to shade(). It sets
  // SurfacePoint::answer where a host's shader, not the material, says what a point covers. Answers last until the next
  // call.
  virtual void cover(std::span<SurfacePoint> /*points*/) {}

  // Returns how many independent estimates shade() makes of each radiance.
  virtual uint32_t estimates() const { return 1; }

  // Says in which media the points of the next call are seen, one entry a point; valid during that call. Only shaders
  // that follow rays inside of volumes read it.
  virtual void within(const MediumStack* /*media*/) {}

  // Writes radiance[i * estimates() + e] = C of dst = C * cover + dst * through at points[i]. Neighbouring points
  // should come from neighbouring pixels: their rays travel in packets.
  virtual void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;

  // Writes the radiance of opaque surfaces at which refracted rays end: direct light and the environment, no further
  // bounce.
  virtual void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;
  // Returns what a ray of a lobe of this roughness sees where it leaves the scene.
  virtual glm::vec3 surroundings(glm::vec3 direction, float roughness) const = 0;

  // Returns the interface for points that reuse rays; null where each needs its own.
  virtual RaySharing* sharing() { return nullptr; }

  // Returns the rough reflection of each point of the last shade(); empty if the shader does not return it apart.
  virtual std::span<const RoughReflection> rough() const { return {}; }
};

}  // namespace sideray::rt
