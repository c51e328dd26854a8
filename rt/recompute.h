// Where a ray meets a triangle that Embree named: double precision, no fused contraction, so that distances and their
// order are the same bits for every packet width and instruction set. Any thread.
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/intersector.h"
#include "rt/trace_table.h"

namespace sideray::rt {

// A vertex as the rasterizer places it: in float, by the instance's matrix.
inline glm::vec3 local_position(const TraceInstance& instance, uint32_t vertex) {
  const glm::mat4x3& m = instance.local_from_object;
  const glm::vec3 p = instance.positions[vertex];
  return {m[0].x * p.x + m[1].x * p.y + m[2].x * p.z + m[3].x, m[0].y * p.x + m[1].y * p.y + m[2].y * p.z + m[3].y,
          m[0].z * p.x + m[1].z * p.y + m[2].z * p.z + m[3].z};
}

struct LocalTriangle {
  glm::vec3 p0, p1, p2;
};

inline LocalTriangle local_triangle(const TraceInstance& instance, uint32_t primitive) {
  const glm::uvec3 t = instance.triangles[primitive];
  return {local_position(instance, t.x), local_position(instance, t.y), local_position(instance, t.z)};
}

// How far float arithmetic on these coordinates may put a ray beside a triangle, in local lengths.
double beside_tolerance(const TraceInstance& instance, const LocalTriangle& triangle, const Ray& ray);

// A point outside the triangle moved onto it; false where it is too far off for rounding to be the reason.
bool clamp_to_triangle(const TraceInstance& instance, const LocalTriangle& triangle, const Ray& ray, double& t,
                       double& u, double& v);

// Moeller and Trumbore 1997. False where the ray does not meet the triangle after all. The distance is rounded to
// float, in which it is stored everywhere: exactly coplanar surfaces then tie, and are ordered by their ids, instead of
// being ordered by the noise in the last bits of a double.
inline bool recompute(const TraceInstance& instance, uint32_t instance_index, uint32_t primitive, const Ray& ray,
                      Hit& hit) {
  const LocalTriangle triangle = local_triangle(instance, primitive);
  const glm::dvec3 p0(triangle.p0), e1 = glm::dvec3(triangle.p1) - p0, e2 = glm::dvec3(triangle.p2) - p0;
  const glm::dvec3 d(ray.direction), s = glm::dvec3(ray.origin) - p0;
  const glm::dvec3 d_x_e2 = glm::cross(d, e2), s_x_e1 = glm::cross(s, e1);
  const double determinant = glm::dot(e1, d_x_e2);
  if (determinant == 0.0) return false;
  const double scale = 1.0 / determinant;
  double u = glm::dot(s, d_x_e2) * scale;
  double v = glm::dot(d, s_x_e1) * scale;
  double t = glm::dot(e2, s_x_e1) * scale;
  if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0) && !clamp_to_triangle(instance, triangle, ray, t, u, v)) return false;
  const auto t_float = static_cast<float>(t);
  hit.distance = static_cast<double>(t_float);
  hit.u = static_cast<float>(u);
  hit.v = std::min(static_cast<float>(v), 1.0f - hit.u);
  hit.instance = instance_index;
  hit.primitive = primitive;
  hit.front = (determinant > 0.0) != instance.mirrored;
  return t_float >= ray.t_near && t_float <= ray.t_far;
}

// The total order of surfaces along a ray: distance, surface id, primitive.
inline bool nearer(const TraceTable& table, const Hit& a, const Hit& b) {
  if (a.distance != b.distance) return a.distance < b.distance;
  const uint32_t id_a = table.instances[a.instance].surface_id, id_b = table.instances[b.instance].surface_id;
  if (id_a != id_b) return id_a < id_b;
  if (a.instance != b.instance) return a.instance < b.instance;
  return a.primitive < b.primitive;
}

// Whether both hits, of one instance, lie on an edge or at a corner that their two triangles share.
bool share_edge(const TraceInstance& instance, const Ray& ray, const Hit& a, const Hit& b);

// Whether two hits of one ray are one crossing of one surface, reported for both triangles at a shared edge or corner.
// `margin`: the difference of their distances that rounding explains.
inline bool same_crossing(const TraceTable& table, const Ray& ray, const Hit& a, const Hit& b, double margin) {
  if (a.instance != b.instance || a.front != b.front || std::abs(a.distance - b.distance) > margin) return false;
  // A builder that splits triangles names one of them twice.
  return a.primitive == b.primitive || share_edge(table.instances[a.instance], ray, a, b);
}

}  // namespace sideray::rt
