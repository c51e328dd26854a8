// Computes what transmissive solids do to a ray: where it is refracted, what it loses on its way (rt/surfaces/media.h says
// which media it is in). Immutable or a value; any thread may use it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "rt/surfaces/media.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Returns whether any surface of the snapshot bends light that comes from the air, or blurs it.
bool bends_light(const model::Snapshot& snapshot);

struct Bend {
  glm::vec3 direction;
  float cosine;  // to the normal on the side of the lower index; Fresnel's term is taken at it
  bool total;    // reflected totally: direction is the mirror direction
};
// Refracts by Snell's law. Vectors are unit, with the normal on the side of `to_eye`.
Bend bend(glm::vec3 to_eye, glm::vec3 normal, float ior_from, float ior_to);

// Returns the shading normal where it faces the viewer, else the geometric one.
glm::vec3 facing_normal(const SurfacePoint& point);

// Returns whether what is seen through the surface is blurred.
bool is_scattered(const SurfacePoint& point);

// Returns one of the directions in which a rough surface lets light through, chosen by the key: among the facets that the
// eye sees (Heitz 2018), a direction that stays on the viewer's side is rejected.
glm::vec3 scattered_direction(const SurfacePoint& point, const Crossing& crossing, uint32_t key);

}  // namespace sideray::rt
