#include "rt/refraction/surfaces_ahead.h"

#include <algorithm>

#include "rt/embree/recompute.h"

namespace sideray::rt {
namespace {

// A further round starts before the last surface, by this share of its distance; the total order tells which surfaces
// are known.
constexpr double step_back = 1e-6;
// The sine of the smallest angle between a refracted ray and the surface.
constexpr float least_elevation = 1e-3f;
// Surfaces up to this many offsets apart along the normal count as being at one place.
constexpr float skin_offsets = 2.0f;
constexpr double endless = std::numeric_limits<double>::infinity();

float step_before(const Hit& hit) {
  return static_cast<float>(hit.distance * (1.0 - step_back));
}

// Returns the thickness of the offset layer around a surface along the incoming ray.
float skin_along_ray(const SurfacePoint& point) {
  return skin_offsets * point.offset / std::max(glm::dot(point.geometric_normal, point.to_eye), least_elevation);
}

}  // namespace

void SurfacesAhead::take(const std::vector<model::Instance>& instances, std::span<const Hit> found, uint32_t layers,
                         Ray& ray) {
  const auto id = [&](const Hit& h) { return instances[h.instance].surface_id; };
  const uint32_t before = count;
  uint32_t taken = 0;
  while (taken < found.size() && count < most) {
    const Hit& hit = found[taken++];
    if (last.instance != no_instance && !nearer(last, id(last), hit, id(hit))) continue;
    hits[count++] = hit;
  }
  const bool none = count == before;
  if (taken == found.size() && (found.size() < layers || (deep && none)))
    known = endless;
  else if (!none)
    known = hits[count - 1].distance;
  deep = none;
  if (!none) begin_at_last(ray);
}

void SurfacesAhead::take_place(std::span<const Hit> found, double known_to, Ray& ray) {
  std::copy(found.begin(), found.end(), hits);
  count = static_cast<uint32_t>(found.size());
  known = known_to;
  if (count > 0) begin_at_last(ray);
}

void SurfacesAhead::begin_at_last(Ray& ray) {
  last = hits[count - 1];
  ray.t_near = std::max(ray.t_near, step_before(last));
}

bool SurfacesAhead::knows_place(const SurfacePoint& first) const {
  // The first hits of a new ray are all surfaces at its origin.
  return last.instance == no_instance || count == most || same_place(first, hits[0].distance) <= known;
}

void SurfacesAhead::end_at(float t_far) {
  while (count > 0 && static_cast<float>(hits[count - 1].distance) > t_far) --count;
  if (known > static_cast<double>(t_far)) known = endless;
}

void SurfacesAhead::forget_behind(const Hit& hit, Ray& ray) {
  count = 0;
  known = hit.distance;
  last = hit;
  ray.t_near = step_before(hit);
}

Hit SurfacesAhead::remove(uint32_t i) {
  const Hit hit = hits[i];
  std::copy(hits + i + 1, hits + count, hits + i);
  --count;
  return hit;
}

void SurfacesAhead::start_anew(double limit) {
  uint32_t here = 0;
  while (here < count && hits[here].distance <= limit) hits[here++].distance = 0.0;
  count = here;
  last.instance = no_instance;
  known = 0.0;
  deep = false;
}

double same_place(const SurfacePoint& point, double distance) {
  return distance + static_cast<double>(skin_along_ray(point));
}

OnwardRay onward_ray(const SurfacePoint& point, float distance, glm::vec3 direction, bool transmitted) {
  const glm::vec3 side = transmitted ? -point.geometric_normal : point.geometric_normal;
  const float elevation = glm::dot(direction, side);
  if (elevation < least_elevation) direction = glm::normalize(direction + side * (least_elevation - elevation));
  const float skin = skin_offsets * point.offset;
  const float t_near = transmitted ? 2.0f * skin / std::max(elevation, least_elevation) : 0.0f;
  return {{point.position + side * (transmitted ? -skin : skin), t_near, direction, farthest},
          static_cast<double>(distance + skin_along_ray(point))};
}

}  // namespace sideray::rt
