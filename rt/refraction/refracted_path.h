// Holds the state of a path that solids refract, from one surface to the next. A value.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "rt/base/ray.h"
#include "rt/refraction/surfaces_ahead.h"
#include "rt/surfaces/media.h"

namespace sideray::rt {

struct RefractedPath {
  // Says what must be searched before a path can continue. Most refracted rays turn at their first surface, so only the
  // surfaces at that place are searched, and opaque ones up to there. For an unrefracted ray, the opaque surface is
  // searched first, then several translucent ones at once: the rest.
  enum class Search : uint8_t { nothing, place, opaque, rest };

  static constexpr int both_estimates = -1;
  static constexpr uint32_t not_made = 0xffffffffu;

  uint32_t pixel, key;
  uint32_t met, wanted;  // number of surfaces
  int estimate;          // the estimate that it adds to, or both_estimates
  Light light;           // the channels that it carries
  Ray ray;
  Cone cone;
  glm::vec3 through;
  float start;     // distance along the ray up to which its medium has absorbed
  float way;       // length of the refracted rays before this one
  double length;   // of all rays before this one
  uint32_t turns;  // rays before this one
  MediumStack media;
  bool refracted;
  float clear;  // for a refracted ray: no opaque surface is nearer; `farthest`: its end has been found
  Hit opaque;   // where a refracted ray ends
  SurfacesAhead ahead;
  Search search;
  uint32_t surface;  // index in NextSurfaces of the surface of ahead.hits[0], then of `next`; or not_made
  Hit next;          // the surface to cross next; no_instance: the path ends
  float way_out;     // where its medium ends behind the last surface that counts; or infinite

  // Returns whether the path hits the back faces that a primary ray in air passes.
  bool hits_culled() const { return refracted || !media.empty(); }
};

}  // namespace sideray::rt
