#include "rt/recompute.h"

#include <array>

namespace sideray::rt {
namespace {

float largest_component(glm::vec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

using Corners = std::array<glm::vec3, 3>;

Corners object_corners(const TraceInstance& instance, uint32_t primitive) {
  const glm::uvec3 t = instance.triangles[primitive];
  return {instance.positions[t.x], instance.positions[t.y], instance.positions[t.z]};
}

// Which corners a hit leans on: those whose opposite edge is farther from the ray than rounding. Three: an inner point.
struct Support {
  std::array<bool, 3> corner;
  int count;
};

Support support(const TraceInstance& instance, const Ray& ray, const Hit& hit) {
  const LocalTriangle triangle = local_triangle(instance, hit.primitive);
  const glm::dvec3 p0(triangle.p0), p1(triangle.p1), p2(triangle.p2), d(ray.direction);
  const double tolerance = beside_tolerance(instance, triangle, ray);
  const double u = static_cast<double>(hit.u), v = static_cast<double>(hit.v);
  const std::array<double, 3> weights{1.0 - u - v, u, v};
  const std::array<glm::dvec3, 3> opposite{p2 - p1, p0 - p2, p1 - p0};
  // Twice the triangle's area, and an edge's length, as seen along the ray (times the direction's length): their
  // quotient is the height over that edge.
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

double beside_tolerance(const TraceInstance& instance, const LocalTriangle& triangle, const Ray& ray) {
  // Embree intersects in object space with a ray transformed in float: a few roundings of the coordinates involved.
  constexpr float roundings = 64.0f * 0x1p-24f;
  const float size =
      largest_component(ray.origin) + largest_component(instance.local_from_object[3]) +
      std::max({largest_component(triangle.p0), largest_component(triangle.p1), largest_component(triangle.p2)});
  return static_cast<double>(roundings * size);
}

bool clamp_to_triangle(const TraceInstance& instance, const LocalTriangle& triangle, const Ray& ray, double& t,
                       double& u, double& v) {
  if (!std::isfinite(u) || !std::isfinite(v) || !std::isfinite(t)) return false;
  const glm::dvec3 p0(triangle.p0), e1 = glm::dvec3(triangle.p1) - p0, e2 = glm::dvec3(triangle.p2) - p0;
  const glm::dvec3 d(ray.direction);
  const std::array<double, 3> weights{std::max(1.0 - u - v, 0.0), std::max(u, 0.0), std::max(v, 0.0)};
  const double scale = 1.0 / (weights[0] + weights[1] + weights[2]);
  const double new_u = weights[1] * scale, new_v = weights[2] * scale;
  const glm::dvec3 to_point = p0 + new_u * e1 + new_v * e2 - glm::dvec3(ray.origin);
  const double new_t = glm::dot(to_point, d) / glm::dot(d, d);
  if (!(glm::length(to_point - new_t * d) <= beside_tolerance(instance, triangle, ray))) return false;
  t = new_t, u = new_u, v = new_v;
  return true;
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
