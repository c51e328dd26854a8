// Gives punctual lights their sizes: a directional light is a disc in the sky, other lights are spheres. Any thread may
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
  // Returns whether refracted paths hit the light often enough to estimate it: true for discs of 5 degrees and more.
  bool is_wide() const { return angular_radius > 0.0436f; }
};

// Returns the lights that emit anything.
std::vector<ReferenceLight> reference_lights(const model::Snapshot& snapshot);

// Describes a sized light as seen from a point: a cone of directions with constant radiance. The integral over the cone
// of radiance times cosine to its axis is the irradiance of the light without its size.
struct LightCone {
  glm::vec3 axis, radiance;
  float aperture;          // 1 - cos(half angle)
  float distance, radius;  // those of the sphere; radius 0 = a disc at infinity
};

// Returns the cone in which a point sees a light; radiance 0 if no light arrives.
LightCone light_cone(const ReferenceLight& light, glm::vec3 position);

// Returns 1 - cos of the angle between the cone's axis and a unit direction, without cancellation for small angles.
float below_axis(const LightCone& cone, glm::vec3 direction);

// Returns the distance to the light in a direction within the cone; `below` is 1 - cos of its angle to the axis.
float distance_to_light(const LightCone& cone, float below);

}  // namespace sideray::rt
