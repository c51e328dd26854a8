// Gives punctual lights their sizes: a directional one is a disc on the sky, the others are spheres. Any thread may
// call it.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "rt/surfaces/surface.h"

namespace sideray::rt {

struct ReferenceLight {
  shading::SrLight light;
  float radius;          // that of the sphere; 0 = a point
  float angular_radius;  // that of the disc, radians; 0 = a direction
  bool sized() const { return radius > 0.0f || angular_radius > 0.0f; }
  // Returns whether refracted paths hit the light often enough to estimate it: discs of 5 degrees and more.
  bool is_wide() const { return angular_radius > 0.0436f; }
};

// Returns the lights that emit anything at all.
std::vector<ReferenceLight> reference_lights(const model::Snapshot& snapshot);

// Describes a sized light as a point sees it: a cone of directions with the same radiance from all of them. The sum
// over the cone of radiance times cosine to its axis is the irradiance that the light has without its size.
struct LightCone {
  glm::vec3 axis, radiance;
  float aperture;          // 1 - cos(half angle)
  float distance, radius;  // those of the sphere; radius 0 = a disc at infinity
};

// Returns the cone in which a point sees a light; radiance 0 where no light arrives.
LightCone light_cone(const ReferenceLight& light, glm::vec3 position);

// Returns 1 - cos between the cone's axis and a unit direction, without cancellation where they are close.
float below_axis(const LightCone& cone, glm::vec3 direction);

// Returns the distance from the point to the light in a direction within the cone, 1 - cos to the axis being `below`.
float distance_to_light(const LightCone& cone, float below);

}  // namespace sideray::rt
