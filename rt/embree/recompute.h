// Recomputes where a ray hits a triangle that Embree reported, in double precision without fused contraction: distances
// and their order have the same bits for every packet width and instruction set. Any thread may call it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <span>
#include <vector>

#include "rt/base/ray.h"
#include "rt/embree/trace_table.h"

namespace sideray::rt {

// Holds x, y and z; the fourth component makes the compiler use whole vectors.
struct LocalPosition {
  alignas(16) float x[4];
};

// Transforms a vertex as the rasterizer does: in float, by the instance's matrix.
inline LocalPosition local_position(const TraceInstance& instance, uint32_t vertex) {
  const glm::vec3 p = instance.positions[vertex];
  const auto& m = instance.columns;
  LocalPosition result;
  for (int i = 0; i < 4; ++i) result.x[i] = m[0][i] * p.x + m[1][i] * p.y + m[2][i] * p.z + m[3][i];
  return result;
}

// Holds where a line hits a triangle's plane. The determinant's sign tells the side (0: no hit); u and v are the
// weights of the second and third vertex.
struct PlaneHit {
  double determinant, t, u, v;
};

struct Double3 {
  double x, y, z;
};

// Intersects a line with a triangle's plane (Moeller and Trumbore 1997), without branches and on scalars, so that it
// compiles to the same arithmetic alone and in a vector.
inline PlaneHit meet_plane(Double3 origin, Double3 d, Double3 p0, Double3 p1, Double3 p2) {
  const Double3 e1{p1.x - p0.x, p1.y - p0.y, p1.z - p0.z}, e2{p2.x - p0.x, p2.y - p0.y, p2.z - p0.z};
  const Double3 s{origin.x - p0.x, origin.y - p0.y, origin.z - p0.z};
  const Double3 a{d.y * e2.z - d.z * e2.y, d.z * e2.x - d.x * e2.z, d.x * e2.y - d.y * e2.x};
  const Double3 b{s.y * e1.z - s.z * e1.y, s.z * e1.x - s.x * e1.z, s.x * e1.y - s.y * e1.x};
  const double determinant = e1.x * a.x + e1.y * a.y + e1.z * a.z;
  const double scale = 1.0 / determinant;
  return {determinant, (e2.x * b.x + e2.y * b.y + e2.z * b.z) * scale, (s.x * a.x + s.y * a.y + s.z * a.z) * scale,
          (d.x * b.x + d.y * b.y + d.z * b.z) * scale};
}

// Moves a point outside the triangle onto it. Returns false if it is too far away for rounding to be the reason.
bool clamp_to_triangle(const TraceInstance& instance, uint32_t primitive, const Ray& ray, PlaneHit& hit);

// Does the part of recompute() that follows the plane's intersection.
inline bool finish_hit(const TraceInstance& instance, uint32_t instance_index, uint32_t primitive, const Ray& ray,
                       PlaneHit plane, Hit& hit) {
  if (plane.determinant == 0.0) return false;
  const bool inside = plane.u >= 0.0 && plane.v >= 0.0 && plane.u + plane.v <= 1.0;
  if (!inside && !clamp_to_triangle(instance, primitive, ray, plane)) return false;
  const auto distance = static_cast<float>(plane.t);
  hit.distance = plane.t;
  hit.u = static_cast<float>(plane.u);
  hit.v = std::min(static_cast<float>(plane.v), 1.0f - hit.u);
  hit.instance = instance_index;
  hit.primitive = primitive;
  hit.front = (plane.determinant > 0.0) != instance.mirrored;
  return distance >= ray.t_near && distance <= ray.t_far;
}

// Returns false if the ray does not hit the triangle after all, or hits it beyond the ray's ends.
bool recompute(const TraceInstance& instance, uint32_t instance_index, uint32_t primitive, const Ray& ray, Hit& hit);

// Distances that differ by less than this share count as equal. It is above the rounding of the recomputation in double
// between triangles of one plane, and below the smallest step between planes whose corners, in float, differ.
inline constexpr double coplanar_share = 0x1p-34;

// Defines the total order of surfaces along a ray: distance, surface id, primitive.
inline bool nearer(const Hit& a, uint32_t id_a, const Hit& b, uint32_t id_b) {
  if (std::abs(a.distance - b.distance) > coplanar_share * b.distance) return a.distance < b.distance;
  if (id_a != id_b) return id_a < id_b;
  if (a.instance != b.instance) return a.instance < b.instance;
  return a.primitive < b.primitive;
}

inline bool nearer(const TraceTable& table, const Hit& a, const Hit& b) {
  return nearer(a, table.instances[a.instance].surface_id, b, table.instances[b.instance].surface_id);
}

// Names a triangle that Embree reported.
struct NamedTriangle {
  uint32_t instance, primitive;
  auto operator<=>(const NamedTriangle&) const = default;
};

// Embree's kernels transform and intersect in float and round differently, so they may disagree on whether a ray close
// to a triangle's edge hits it. Returns the largest distance from an edge at which they may disagree, in local lengths
// as seen along the ray, if the hit is that close to an edge of its triangle; otherwise 0.
double near_edge(const TraceTable& table, const Ray& ray, const Hit& hit);

// Returns true if a cheap bound shows that near_edge() is 0; false means unknown. Needs the triangle's local corners
// and the hit on its plane.
bool is_clear_of_edges(const TraceInstance& instance, const std::array<LocalPosition, 3>& corners, const Ray& ray,
                       const PlaneHit& plane);

// A hit whose barycentric weights are all larger is far from edges, unless its triangle is about as small as rounding.
inline constexpr float edge_weight = 1.0f / 32;

inline constexpr double beside_an_edge = 4.0;  // times near_edge(): an offset that is clear of the edge

// Returns the sideways offset for the rays_beside() that decide hits near an edge; 0: no hit is near one.
inline double edge_offset(const TraceTable& table, const Ray& ray, std::span<const Hit> hits) {
  double offset = 0.0;
  for (const Hit& hit : hits)
    if (std::min({hit.u, hit.v, 1.0f - hit.u - hit.v}) < edge_weight)
      offset = std::max(offset, beside_an_edge * near_edge(table, ray, hit));
  return offset;
}

// Holds a ray and parallel rays around it: together they fill a packet, and they are dense enough that one of them hits
// every triangle of an ordinary corner.
using RayBundle = std::array<Ray, 8>;
RayBundle rays_beside(const Ray& ray, double offset);

// Decides what the first ray hits among the triangles that Embree reported for all rays of the bundle. The ray hits a
// triangle if it does so in double precision and, near an edge, if all rays hit something at that distance. So a ray
// near a surface's border misses it, whatever Embree says; within a surface, or between two that touch, it hits what
// double precision finds. Hits are in no order and include back faces and holes.
void decide_near_edges(const TraceTable& table, const RayBundle& rays, double offset,
                       std::span<const NamedTriangle> named, std::vector<Hit>& hits);

// Decides whether a ray hits a triangle that Embree reported. open: the ray passes so close to an edge that
// decide_near_edges() must decide; then `offset` is set for it.
enum class Meeting { hit, miss, open };
Meeting decide_alone(const TraceTable& table, const Ray& ray, NamedTriangle named, Hit& hit, double& offset);

// Returns whether both hits, of one instance, lie on an edge or corner that their two triangles share.
bool share_edge(const TraceInstance& instance, const Ray& ray, const Hit& a, const Hit& b);

// Returns whether two hits of one ray are one crossing of a surface, reported for both triangles at a shared edge or
// corner. `margin`: the difference of distances that rounding explains.
inline bool same_crossing(const TraceTable& table, const Ray& ray, const Hit& a, const Hit& b, double margin) {
  if (a.instance != b.instance || a.front != b.front || std::abs(a.distance - b.distance) > margin) return false;
  // A builder that splits triangles may report one of them twice.
  return a.primitive == b.primitive || share_edge(table.instances[a.instance], ray, a, b);
}

}  // namespace sideray::rt
