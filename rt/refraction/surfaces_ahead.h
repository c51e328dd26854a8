// Shared by rays that are followed through translucent surfaces, those of pictures and those of paths: the surfaces
// ahead of a ray, and how it restarts behind a surface. Values; any thread may use them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/ray.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// A translucent surface this share of the distance before an opaque one lies on it, as in ViewRays::end_of_ray.
inline constexpr float on_opaque_surface = 0x1p-21f;

// Holds a ray's next translucent surfaces, as far as they have been found.
struct SurfacesAhead {
  static constexpr uint32_t most = 4;

  Hit hits[most];  // in order
  Hit last;        // the last one found on the ray; its instance is no_instance where there is none
  uint32_t count = 0;
  double known = 0.0;  // along the ray: up to there are no others; infinite: there are no more
  bool deep = false;   // more surfaces are at one place than a round of `most` finds

  SurfacesAhead() { last.instance = no_instance; }

  bool complete() const { return known == std::numeric_limits<double>::infinity(); }
  // Returns whether all surfaces at the place of hits[0], whose surface is `first`, are in `hits`, as far as there is room.
  bool knows_place(const SurfacePoint& first) const;
  // Takes what Intersector::nearest_places() found on a new ray, and lets its next round begin there.
  void take_place(std::span<const Hit> found, double known_to, Ray& ray);
  // Takes the next of what a traversal for up to `layers` surfaces found, in order, and lets the ray's next round begin there.
  void take(const std::vector<model::Instance>& instances, std::span<const Hit> found, uint32_t layers, Ray& ray);
  // Forgets all: there are no more.
  void end() { count = 0, known = std::numeric_limits<double>::infinity(); }
  // Leaves out what lies behind the end of the ray.
  void end_at(float t_far);
  // Forgets all behind `hit`, which was the last to count: the next round begins there.
  void forget_behind(const Hit& hit, Ray& ray);
  // Returns the hit with index `i` and closes the gap that it leaves.
  Hit remove(uint32_t i);
  // Keeps those up to `limit`, as the first of a new ray that starts there, and drops the others.
  void start_anew(double limit);

 private:
  void begin_at_last(Ray& ray);
};

// Says which surface of several at one place comes next: those that are entered come first, for a medium that begins where
// another ends leaves no gap. `first`, that of hits[0], is left; `exits` says of a hit whether its medium ends there.
template <typename Exits>
uint32_t first_entered(const SurfacesAhead& ahead, const SurfacePoint& first, const Exits& exits);

// Describes a ray that leaves a surface.
struct OnwardRay {
  Ray ray;
  double limit;  // along the ray that arrived: surfaces up to there are at the same place, and still to be crossed
};

// `distance`: that of the surface along the ray that arrived. The new ray starts at a point on the near side of the surface,
// for an opaque surface may lie on it; translucent surfaces count from beyond it.
OnwardRay onward_ray(const SurfacePoint& point, float distance, glm::vec3 direction, bool transmitted);

// Returns up to where along the ray that arrived at `point`, at `distance`, surfaces count as being at one place.
double same_place(const SurfacePoint& point, double distance);

template <typename Exits>
uint32_t first_entered(const SurfacesAhead& ahead, const SurfacePoint& first, const Exits& exits) {
  const double limit = same_place(first, ahead.hits[0].distance);
  for (uint32_t i = 1; i < ahead.count && ahead.hits[i].distance <= limit; ++i)
    if (!exits(ahead.hits[i])) return i;
  return 0;
}

}  // namespace sideray::rt
