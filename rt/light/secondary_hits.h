// Declares how those who follow rays ask for the light of what the rays hit.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "rt/surfaces/surface_batch.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {

// Shades secondary hits, which mirrors show. They have no further mirrors: the environment takes their place.
class SecondaryHitShader {
 public:
  virtual ~SecondaryHitShader() = default;
  virtual void shade_secondary_hits(std::span<const HitPlace> hits, glm::vec3* radiance) = 0;
  // Shades translucent surfaces before the secondary hits, without shadows, and says how each is composited.
  virtual void shade_in_front(std::span<const HitPlace> hits, shading::SrBlend* blends, glm::vec3* radiance) = 0;
  // Writes what each of the rays sees that leave the scene.
  virtual void surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const = 0;
};

}  // namespace sideray::rt
