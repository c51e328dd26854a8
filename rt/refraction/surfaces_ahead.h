// Tracks the surfaces ahead of rays that pass translucent surfaces, for pictures and for paths, and how a ray restarts
// behind a surface. Values; any thread may use them.
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

// A translucent surface less than this share of the distance in front of an opaque one counts as lying on it, as in
// ViewRays::end_of_ray.
inline constexpr float on_opaque_surface = 0x1p-21f;

// Holds the next translucent surfaces of a ray, as far as they have been found.
struct SurfacesAhead {
  static constexpr uint32_t most = 4;

  Hit hits[most];  // in order
  Hit last;        // the last hit found on the ray; no_instance: there is none
  uint32_t count = 0;
  double known = 0.0;  // distance up to which all surfaces are known; infinite: there are no more
  bool deep = false;   // more surfaces are at one place than a round of `most` finds

  SurfacesAhead() { last.instance = no_instance; }

  bool complete() const { return known == std::numeric_limits<double>::infinity(); }
  // Returns whether `hits` has all surfaces at the place of hits[0] that fit; `first` is the surface of hits[0].
  bool knows_place(const SurfacePoint& first) const;
  // Takes the result of Intersector::nearest_places() for a new ray, and sets where its next round starts.
  void take_place(std::span<const Hit> found, double known_to, Ray& ray);
  // Takes the next hits from a traversal for up to `layers` surfaces, in order, and sets where the ray's next round
  // starts.
  void take(const std::vector<model::Instance>& instances, std::span<const Hit> found, uint32_t layers, Ray& ray);
  // Drops all hits and marks the ray as complete.
  void end() { count = 0, known = std::numeric_limits<double>::infinity(); }
  // Drops hits behind the end of the ray.
  void end_at(float t_far);
  // Drops everything behind `hit`, the last one that counted, where the next round starts.
  void forget_behind(const Hit& hit, Ray& ray);
  // Returns the hit with index `i` and closes the gap that it leaves.
  Hit remove(uint32_t i);
  // Keeps the hits up to `limit` as the first of a new ray that starts there, and drops the others.
  void start_anew(double limit);

 private:
  void begin_at_last(Ray& ray);
};

// Returns which of several surfaces at one place comes next: entered ones come first, because a medium that begins
// where another ends leaves no gap. `first` is the surface of hits[0] and is exited; `exits` returns whether a hit ends
// its medium.
template <typename Exits>
uint32_t first_entered(const SurfacesAhead& ahead, const SurfacePoint& first, const Exits& exits);

// Describes a ray that leaves a surface.
struct OnwardRay {
  Ray ray;
  double limit;  // on the incoming ray: surfaces up to there are at the same place, and still to be crossed
};

// Makes the ray that continues from `point`, which is at `distance` on the incoming ray. It starts on the near side of
// the surface, because an opaque one may lie on it; translucent surfaces count only beyond the surface.
OnwardRay onward_ray(const SurfacePoint& point, float distance, glm::vec3 direction, bool transmitted);

// Returns the distance on the incoming ray up to which surfaces count as being at the place of `point`, which is at
// `distance`.
double same_place(const SurfacePoint& point, double distance);

template <typename Exits>
uint32_t first_entered(const SurfacesAhead& ahead, const SurfacePoint& first, const Exits& exits) {
  const double limit = same_place(first, ahead.hits[0].distance);
  for (uint32_t i = 1; i < ahead.count && ahead.hits[i].distance <= limit; ++i)
    if (!exits(ahead.hits[i])) return i;
  return 0;
}

}  // namespace sideray::rt
