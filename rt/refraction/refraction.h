// Computes how transmissive solids refract and attenuate a ray (rt/surfaces/media.h tracks the media around it).
// Immutable or a value; any thread may use it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "rt/surfaces/media.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Returns whether any surface of the snapshot bends or blurs light from air.
bool bends_light(const model::Snapshot& snapshot);

struct Bend {
  glm::vec3 direction;
  float cosine;  // to the normal, on the side of the lower index; argument of the Fresnel term
  bool total;    // reflected totally: direction is the mirror direction
};
// Refracts by Snell's law. Vectors are unit, with the normal on the side of `to_eye`.
Bend bend(glm::vec3 to_eye, glm::vec3 normal, float ior_from, float ior_to);

// Returns the shading normal if it faces the viewer, else the geometric one.
glm::vec3 facing_normal(const SurfacePoint& point);

// Returns whether the surface blurs the light behind it.
bool is_scattered(const SurfacePoint& point);

// Returns one of the directions in which a rough surface transmits light, chosen by the key: by facets visible to the
// eye (Heitz 2018), rejecting directions on the viewer's side.
glm::vec3 scattered_direction(const SurfacePoint& point, const Crossing& crossing, uint32_t key);

struct RoughTurn {
  glm::vec3 direction;
  bool transmitted;  // else it stays on the viewer's side
};
// Returns how a rough surface that would reflect totally if it were smooth continues light: a facet, chosen by the key
// as above, transmits or reflects it. Without facets light would never leave a ball, whose chords all meet the surface
// at the same angle.
RoughTurn turned_by_facet(const SurfacePoint& point, const Crossing& crossing, uint32_t key);

}  // namespace sideray::rt
