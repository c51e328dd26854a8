#include "rt/embree/recompute.h"

#include <array>

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

// Bounds how far float arithmetic on these coordinates may put a ray beside a triangle, in local lengths: Embree
// intersects in object space with a ray transformed in float, which takes a few roundings of the coordinates involved.
double beside_tolerance(const TraceInstance& instance, const Corners& corners, const Ray& ray) {
  constexpr float roundings = 64.0f * 0x1p-24f;
  float size = 0.0f;
  for (const glm::vec3& p : corners) size = std::max(size, largest_component(p));
  return static_cast<double>(roundings *
                             (size + largest_component(ray.origin) + largest_component(translation(instance))));
}

// Finds which corners a hit depends on: those whose opposite edge is farther from the ray than rounding. A hit that
// depends on all three is an inner point.
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
  // These are twice the triangle's area, and an edge's length, as seen along the ray (times the direction's length):
  // their quotient is the height over that edge.
  const double area = std::abs(glm::dot(d, glm::cross(p1 - p0, p2 - p0)));
  Support result{};
  for (size_t i = 0; i < 3; ++i) {
    result.corner[i] = weights[i] * area > tolerance * glm::length(glm::cross(opposite[i], d));
    result.count += result.corner[i];
  }
  return result;
}

bool is_corner(const Corners& corners, glm::vec3 p) {
  return p == corners[0] || p == corners[1] || p == corners[2];
}

}  // namespace

bool clamp_to_triangle(const TraceInstance& instance, uint32_t primitive, const Ray& ray, PlaneHit& hit) {
  if (!std::isfinite(hit.u) || !std::isfinite(hit.v) || !std::isfinite(hit.t)) return false;
  const Corners corners = local_corners(instance, primitive);
  const glm::dvec3 p0(corners[0]), e1 = glm::dvec3(corners[1]) - p0, e2 = glm::dvec3(corners[2]) - p0;
  const glm::dvec3 d(ray.direction);
  const std::array<double, 3> weights{std::max(1.0 - hit.u - hit.v, 0.0), std::max(hit.u, 0.0), std::max(hit.v, 0.0)};
  const double scale = 1.0 / (weights[0] + weights[1] + weights[2]);
  const double u = weights[1] * scale, v = weights[2] * scale;
  const glm::dvec3 to_point = p0 + u * e1 + v * e2 - glm::dvec3(ray.origin);
  const double t = glm::dot(to_point, d) / glm::dot(d, d);
  if (!(glm::length(to_point - t * d) <= beside_tolerance(instance, corners, ray))) return false;
  hit.t = t;
  hit.u = u;
  hit.v = v;
  return true;
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
  // Two triangles on the same three corners are two surfaces, also at their edges.
  if (is_corner(corners_b, corners_a[0]) && is_corner(corners_b, corners_a[1]) && is_corner(corners_b, corners_a[2]))
    return false;
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k)
      if (support_a.corner[i] && support_b.corner[k] && corners_a[i] == corners_b[k]) return true;
  return false;
}

}  // namespace sideray::rt
