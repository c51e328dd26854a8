// Declares the interface by which ray tracers have their hits shaded.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "rt/surfaces/surface_batch.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {

// Shades secondary hits, which are visible in mirrors. They reflect only the environment.
class SecondaryHitShader {
 public:
  virtual ~SecondaryHitShader() = default;
  virtual void shade_secondary_hits(std::span<const HitPlace> hits, glm::vec3* radiance) = 0;
  // Shades translucent surfaces in front of secondary hits, without shadows, and sets how each is composited.
  virtual void shade_in_front(std::span<const HitPlace> hits, shading::SrBlend* blends, glm::vec3* radiance) = 0;
  // Writes the environment for rays that leave the scene.
  virtual void surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const = 0;
};

}  // namespace sideray::rt
