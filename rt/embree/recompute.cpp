#include "rt/embree/recompute.h"

#include <array>
#include <limits>
#include <tuple>

namespace sideray::rt {
namespace {

using Corners = std::array<glm::vec3, 3>;

float largest_component(glm::vec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

glm::vec3 translation(const TraceInstance& instance) {
  return {instance.columns[3][0], instance.columns[3][1], instance.columns[3][2]};
}

Corners object_corners(const TraceInstance& instance, uint32_t primitive) {
  const glm::uvec3 t = instance.triangles[primitive];
  return {instance.positions[t.x], instance.positions[t.y], instance.positions[t.z]};
}

Corners local_corners(const TraceInstance& instance, uint32_t primitive) {
  const glm::uvec3 t = instance.triangles[primitive];
  Corners corners;
  for (int i = 0; i < 3; ++i) {
    const LocalPosition p = local_position(instance, t[i]);
    corners[static_cast<size_t>(i)] = {p.x[0], p.x[1], p.x[2]};
  }
  return corners;
}

Double3 double3(glm::vec3 v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

// Bounds how far float rounding may move a ray beside a triangle, in local lengths: Embree intersects in object space
// with a ray transformed in float, which takes a few roundings of the coordinates involved.
double beside_tolerance(const TraceInstance& instance, const Corners& corners, const Ray& ray,
                        float roundings = 64.0f * 0x1p-24f) {
  float size = 0.0f;
  for (const glm::vec3& p : corners) size = std::max(size, largest_component(p));
  return static_cast<double>(roundings *
                             (size + largest_component(ray.origin) + largest_component(translation(instance))));
}

// Finds the corners that a hit depends on: those whose opposite edge is farther from the ray than rounding. A hit that
// depends on all three is inside the triangle.
struct Support {
  std::array<bool, 3> corner;
  int count;
};

Support support(const TraceInstance& instance, const Ray& ray, const Hit& hit) {
  const Corners corners = local_corners(instance, hit.primitive);
  const glm::dvec3 p0(corners[0]), p1(corners[1]), p2(corners[2]), d(ray.direction);
  const double tolerance = beside_tolerance(instance, corners, ray);
  const double u = static_cast<double>(hit.u), v = static_cast<double>(hit.v);
  const std::array<double, 3> weights{1.0 - u - v, u, v};
  const std::array<glm::dvec3, 3> opposite{p2 - p1, p0 - p2, p1 - p0};
  // Twice the triangle's area and an edge's length, as seen along the ray (times the direction's length): their
  // quotient is the height over that edge.
  const double area = std::abs(glm::dot(d, glm::cross(p1 - p0, p2 - p0)));
  Support result{};
  for (size_t i = 0; i < 3; ++i) {
    result.corner[i] = weights[i] * area > tolerance * glm::length(glm::cross(opposite[i], d));
    result.count += result.corner[i];
  }
  return result;
}

constexpr float edge_roundings = 8.0f * 0x1p-24f;
constexpr float double_roundings = 0x1p-40f;  // the rounding of doubles, with much to spare

PlaneHit meet(const Corners& corners, const Ray& ray) {
  return meet_plane(double3(ray.origin), double3(ray.direction), double3(corners[0]), double3(corners[1]),
                    double3(corners[2]));
}

bool is_inside(const PlaneHit& plane) {
  return plane.u >= 0.0 && plane.v >= 0.0 && plane.u + plane.v <= 1.0;
}

// Returns the smallest height over an edge, as seen along the ray; it is negative outside the triangle.
double least_height(const Corners& corners, const Ray& ray, const PlaneHit& plane) {
  const glm::dvec3 p0(corners[0]), p1(corners[1]), p2(corners[2]), d(ray.direction);
  const std::array<double, 3> weights{1.0 - plane.u - plane.v, plane.u, plane.v};
  const std::array<glm::dvec3, 3> opposite{p2 - p1, p0 - p2, p1 - p0};
  const double area = std::abs(plane.determinant);
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < 3; ++i) least = std::min(least, weights[i] * area / glm::length(glm::cross(opposite[i], d)));
  return least;
}

// Returns the largest change of distance per unit that the ray moves sideways.
double slope_of(const Corners& corners, const PlaneHit& plane) {
  const glm::dvec3 p0(corners[0]), normal = glm::cross(glm::dvec3(corners[1]) - p0, glm::dvec3(corners[2]) - p0);
  return glm::length(normal) / std::max(std::abs(plane.determinant), 1e-300);
}

bool clamp_within(const Corners& corners, const Ray& ray, PlaneHit& hit, double tolerance) {
  if (!std::isfinite(hit.u) || !std::isfinite(hit.v) || !std::isfinite(hit.t)) return false;
  const glm::dvec3 p0(corners[0]), e1 = glm::dvec3(corners[1]) - p0, e2 = glm::dvec3(corners[2]) - p0;
  const glm::dvec3 d(ray.direction);
  const std::array<double, 3> weights{std::max(1.0 - hit.u - hit.v, 0.0), std::max(hit.u, 0.0), std::max(hit.v, 0.0)};
  const double scale = 1.0 / (weights[0] + weights[1] + weights[2]);
  const double u = weights[1] * scale, v = weights[2] * scale;
  const glm::dvec3 to_point = p0 + u * e1 + v * e2 - glm::dvec3(ray.origin);
  const double t = glm::dot(to_point, d) / glm::dot(d, d);
  if (!(glm::length(to_point - t * d) <= tolerance)) return false;
  hit.t = t;
  hit.u = u;
  hit.v = v;
  return true;
}

// Intersects in double precision; a point on an edge within the rounding of doubles is inside.
bool meets(const TraceInstance& instance, const Corners& corners, const Ray& ray, PlaneHit& plane) {
  plane = meet(corners, ray);
  if (plane.determinant == 0.0) return false;
  return is_inside(plane) ||
         clamp_within(corners, ray, plane, beside_tolerance(instance, corners, ray, double_roundings));
}

bool is_corner(const Corners& corners, glm::vec3 p) {
  return p == corners[0] || p == corners[1] || p == corners[2];
}

}  // namespace

bool clamp_to_triangle(const TraceInstance& instance, uint32_t primitive, const Ray& ray, PlaneHit& hit) {
  const Corners corners = local_corners(instance, primitive);
  return clamp_within(corners, ray, hit, beside_tolerance(instance, corners, ray));
}

double near_edge(const TraceTable& table, const Ray& ray, const Hit& hit) {
  const TraceInstance& instance = table.instances[hit.instance];
  const Corners corners = local_corners(instance, hit.primitive);
  const double tolerance = beside_tolerance(instance, corners, ray, edge_roundings);
  return least_height(corners, ray, meet(corners, ray)) <= tolerance ? tolerance : 0.0;
}

bool is_clear_of_edges(const TraceInstance& instance, const std::array<LocalPosition, 3>& local, const Ray& ray,
                       const PlaneHit& plane) {
  Corners corners;
  for (size_t i = 0; i < 3; ++i) corners[i] = {local[i].x[0], local[i].x[1], local[i].x[2]};
  // Across the ray, the hit lies at least `weighed` / (longest edge * length of d) from each edge.
  const double weighed = std::min({plane.u, plane.v, 1.0 - plane.u - plane.v}) * std::abs(plane.determinant);
  const glm::dvec3 p0(corners[0]), p1(corners[1]), p2(corners[2]), d(ray.direction);
  const double longest = std::max({glm::dot(p1 - p0, p1 - p0), glm::dot(p2 - p1, p2 - p1), glm::dot(p0 - p2, p0 - p2)});
  const double tolerance = beside_tolerance(instance, corners, ray, edge_roundings);
  constexpr double spare = 1.001;  // exceeds the rounding errors of both bounds
  return weighed > 0.0 && weighed * weighed > spare * tolerance * tolerance * longest * glm::dot(d, d);
}

RayBundle rays_beside(const Ray& ray, double offset) {
  // The cosines and sines of sevenths of a turn.
  constexpr std::array<std::array<double, 2>, 7> around{{{1.0, 0.0},
                                                         {0.62348980185873353, 0.78183148246802981},
                                                         {-0.22252093395631440, 0.97492791218182361},
                                                         {-0.90096886790241913, 0.43388373911755812},
                                                         {-0.90096886790241913, -0.43388373911755812},
                                                         {-0.22252093395631440, -0.97492791218182361},
                                                         {0.62348980185873353, -0.78183148246802981}}};
  const glm::dvec3 d = glm::normalize(glm::dvec3(ray.direction));
  const glm::dvec3 other = std::abs(d.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 a = glm::normalize(glm::cross(d, other)) * offset, b = glm::cross(d, a);
  RayBundle rays;
  rays[0] = ray;
  for (size_t i = 0; i < around.size(); ++i) {
    rays[i + 1] = ray;
    rays[i + 1].origin = glm::dvec3(ray.origin) + around[i][0] * a + around[i][1] * b;
  }
  return rays;
}

namespace {

// Holds where a ray of the bundle hits a triangle, with its slope_of().
struct MetPlane {
  double t, slope;
};

// Holds a triangle that the first ray hits, or misses by no more than rounding.
struct OpenHit {
  NamedTriangle named;
  PlaneHit plane;
  double slope;
  bool near, beside;
};

}  // namespace

void decide_near_edges(const TraceTable& table, const RayBundle& rays, double offset,
                       std::span<const NamedTriangle> named, std::vector<Hit>& hits) {
  std::array<std::vector<MetPlane>, std::tuple_size_v<RayBundle>> met;
  std::vector<OpenHit> open;
  for (const NamedTriangle& n : named) {
    const TraceInstance& instance = table.instances[n.instance];
    const Corners corners = local_corners(instance, n.primitive);
    for (size_t k = 0; k < rays.size(); ++k) {
      PlaneHit plane;
      const bool meeting = meets(instance, corners, rays[k], plane);
      if (plane.determinant == 0.0) continue;
      if (meeting) met[k].push_back({plane.t, slope_of(corners, plane)});
      if (k > 0) continue;
      const double tolerance = beside_tolerance(instance, corners, rays[0], edge_roundings);
      if (meeting)
        open.push_back({n, plane, slope_of(corners, plane), least_height(corners, rays[0], plane) <= tolerance, false});
      else if (clamp_within(corners, rays[0], plane, tolerance))
        open.push_back({n, plane, slope_of(corners, plane), true, true});
    }
  }
  const double length = glm::length(glm::dvec3(rays[0].direction));
  const auto is_at = [&](const MetPlane& m, const OpenHit& o) {
    return std::abs(m.t - o.plane.t) <= offset * (2.0 * (m.slope + o.slope) + 1.0 / length);
  };
  const auto goes_on = [&](const OpenHit& o) {
    return std::all_of(met.begin() + 1, met.end(), [&](const std::vector<MetPlane>& list) {
      return std::any_of(list.begin(), list.end(), [&](const MetPlane& m) { return is_at(m, o); });
    });
  };
  hits.clear();
  // At a sliver in a corner Embree may report only its neighbours, which the ray itself does not hit. Then one of them
  // gets the hit.
  const auto add = [&](const OpenHit& o) {
    Hit hit;
    if (o.beside && std::any_of(met[0].begin(), met[0].end(), [&](const MetPlane& m) { return is_at(m, o); })) return;
    if (o.near && !goes_on(o)) return;
    if (!finish_hit(table.instances[o.named.instance], o.named.instance, o.named.primitive, rays[0], o.plane, hit)) return;
    hits.push_back(hit);
    if (o.beside) met[0].push_back({o.plane.t, o.slope});
  };
  std::for_each(open.begin(), open.end(), add);
}

Meeting decide_alone(const TraceTable& table, const Ray& ray, NamedTriangle named, Hit& hit, double& offset) {
  const TraceInstance& instance = table.instances[named.instance];
  const Corners corners = local_corners(instance, named.primitive);
  const PlaneHit plane = meet(corners, ray);
  const auto distance = static_cast<float>(plane.t);
  if (plane.determinant == 0.0 || !(distance >= ray.t_near && distance <= ray.t_far)) return Meeting::miss;
  const double tolerance = beside_tolerance(instance, corners, ray, edge_roundings);
  const double height = least_height(corners, ray, plane);
  if (height < -tolerance) return Meeting::miss;
  if (height > tolerance)
    return finish_hit(instance, named.instance, named.primitive, ray, plane, hit) ? Meeting::hit : Meeting::miss;
  offset = beside_an_edge * tolerance;
  return Meeting::open;
}

bool recompute(const TraceInstance& instance, uint32_t instance_index, uint32_t primitive, const Ray& ray, Hit& hit) {
  const Corners corners = local_corners(instance, primitive);
  const PlaneHit plane = meet_plane(double3(ray.origin), double3(ray.direction), double3(corners[0]),
                                    double3(corners[1]), double3(corners[2]));
  return finish_hit(instance, instance_index, primitive, ray, plane, hit);
}

bool share_edge(const TraceInstance& instance, const Ray& ray, const Hit& a, const Hit& b) {
  const Support support_a = support(instance, ray, a), support_b = support(instance, ray, b);
  if (support_a.count == 3 || support_b.count == 3) return false;
  const Corners corners_a = object_corners(instance, a.primitive), corners_b = object_corners(instance, b.primitive);
  // Two triangles on the same three corners are two surfaces, even at their edges.
  if (is_corner(corners_b, corners_a[0]) && is_corner(corners_b, corners_a[1]) && is_corner(corners_b, corners_a[2]))
    return false;
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k)
      if (support_a.corner[i] && support_b.corner[k] && corners_a[i] == corners_b[k]) return true;
  return false;
}

}  // namespace sideray::rt
