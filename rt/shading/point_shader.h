// What the layer tracer asks for the light that leaves surfaces: batches of points in, radiance out. Implementations
// hold scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "rt/surfaces/surface.h"

namespace sideray::rt {

// The part of a point's light that one random direction stands for: what rough lobes reflect. radiance * weight is in
// what shade() gave; another estimate of the radiance may take its place.
struct RoughReflection {
  glm::vec3 radiance;
  glm::vec3 weight;  // 0: nothing here is left to chance
  float roughness;   // perceptual, of the lobe that reflects most
  float nearness;    // of what it reflects: 1 / distance, averaged over what the ray met; 0 = the environment
};

// What a shader did since it began.
struct ShaderWork {
  // Traversals; a reflection that looks for translucent surfaces too starts two.
  uint64_t rays_reflection = 0, rays_shadow = 0;
  // Left out, since SurfacePoint::allowance covers them; and points that had rays, all of which were.
  uint64_t rays_skipped = 0, points_skipped = 0;
  // That a host's shader was asked for; and those of its results that were no numbers.
  uint64_t points_asked = 0, points_not_finite = 0;
};

class PointShader : public ShaderWork {
 public:
  virtual ~PointShader() = default;

  // Before the points are blended, and shade() is given those of them that count: sets SurfacePoint::answer where what
  // they cover is not their material's to say. Answers last until the next call.
  virtual void cover(std::span<SurfacePoint> /*points*/) {}

  // Independent estimates that shade() makes of each radiance.
  virtual uint32_t estimates() const { return 1; }

  // radiance[i * estimates() + e] = C of dst = C * cover + dst * through at points[i]. Neighbouring points should come
  // from neighbouring pixels: their rays travel in packets.
  virtual void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;

  // The same of opaque surfaces that a bent ray ends at: direct light and the environment, no further bounce.
  virtual void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;
  // What a ray sees that leaves the scene; of a lobe of this roughness.
  virtual glm::vec3 surroundings(glm::vec3 direction, float roughness) const = 0;

  // Of the points that shade() had last, one each; empty where it does not tell them apart.
  virtual std::span<const RoughReflection> rough() const { return {}; }
};

// The same of what mirrors show, which has no further mirrors: the environment takes their place.
class SecondaryHitShader {
 public:
  virtual ~SecondaryHitShader() = default;
  // As PointShader::cover(), of translucent points.
  virtual void cover_secondary_hits(std::span<SurfacePoint> /*points*/) {}
  // `allowances`: by how much radiance may be off, a point; or empty. Each becomes what is left of it.
  virtual void shade_secondary_hits(std::span<const SurfacePoint> points, std::span<float> allowances,
                                    glm::vec3* radiance) = 0;
  // Of translucent surfaces before it: no shadows.
  virtual void shade_in_front(std::span<const SurfacePoint> points, glm::vec3* radiance) = 0;
  virtual glm::vec3 surroundings(glm::vec3 direction, float roughness) const = 0;
};

}  // namespace sideray::rt
