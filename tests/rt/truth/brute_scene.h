// Scenes whose every surface along a ray is found without acceleration structures: all triangles, in double precision.
#pragma once

#include <sideray/ground_truth.h>

#include <algorithm>
#include <random>

#include "rt/refraction/refraction_scene.h"

namespace sideray::rt::test {

// Apart from the intersector's BruteHit by name too: two types of one name in one program are undefined.
struct SurfaceMet {
  double distance;
  uint32_t surface, primitive;
  bool translucent;
  glm::dvec3 normal;  // geometric, on the side of the ray
  sideray_surface_face face;
  sideray_surface_kind kind;
};

// Holds all hits of a ray, in order. `margin` is the ray's distance to an edge (in barycentric weights), or between two
// surfaces (as a share of their distance): rounding may change the result where it is small.
struct SurfacesMet {
  std::vector<SurfaceMet> all;
  double margin = 1.0;

  const SurfaceMet* first(bool translucent) const {
    for (const SurfaceMet& hit : all)
      if (hit.translucent == translucent) return &hit;
    return nullptr;
  }
};

class BruteScene {
 public:
  // Returns the surface id.
  uint32_t add(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices,
               const sideray_material_desc& material, const glm::dmat4& world_from_object = glm::dmat4(1.0)) {
    const uint32_t id =
        scene.add(positions, std::vector<glm::vec2>(positions.size()), indices, material, world_from_object);
    const bool absent = material.alpha_mode == SIDERAY_MASK
                            ? material.base_color[3] < material.alpha_cutoff
                            : material.alpha_mode == SIDERAY_BLEND && material.base_color[3] < 1.0f / 255.0f;
    const bool translucent = material.alpha_mode == SIDERAY_BLEND || material.transmission > 0.0f;
    const sideray_surface_kind kind = material.transmission > 0.0f  ? material.thickness > 0.0f ? SIDERAY_KIND_VOLUME : SIDERAY_KIND_THIN
                                      : translucent                              ? SIDERAY_KIND_BLEND
                                      : material.alpha_mode == SIDERAY_MASK ? SIDERAY_KIND_MASK
                                                                            : SIDERAY_KIND_OPAQUE;
    const bool mirrored = glm::determinant(glm::dmat3(world_from_object)) < 0.0;
    for (uint32_t i = 0; !absent && i < indices.size() / 3; ++i) {
      Triangle t{id, i + 1, translucent, material.double_sided != 0, mirrored, kind, {}};
      for (uint32_t k = 0; k < 3; ++k)
        t.corners[k] = glm::dvec3(world_from_object * glm::dvec4(positions[indices[3 * i + k]], 1.0));
      triangles_.push_back(t);
    }
    return id;
  }

  // Quads in random places and of every kind, tumbled; each its own object.
  void add_random(uint32_t seed, uint32_t count, bool all_double_sided = false) {
    std::mt19937 random(seed);
    const auto number = [&](double low, double high) { return low + (high - low) * (static_cast<double>(random()) / 4294967296.0); };
    for (uint32_t i = 0; i < count; ++i) {
      sideray_material_desc m = plain_material();
      m.double_sided = all_double_sided || i % 3 != 0;
      if (i % 4 == 1) m.alpha_mode = SIDERAY_BLEND, m.base_color[3] = i % 8 == 1 ? 0.5f : 0.001f;
      if (i % 4 == 2) m.transmission = 1.0f, m.roughness = 0.0f;
      if (i % 4 == 3 && i % 8 == 3) m.alpha_mode = SIDERAY_MASK, m.base_color[3] = i % 16 == 3 ? 0.2f : 0.8f;
      glm::dmat4 place = glm::translate(glm::dmat4(1.0), {number(-2, 2), number(-2, 2), number(-7, -3)});
      place = glm::rotate(place, number(0, 6), glm::normalize(glm::dvec3(number(-1, 1), number(-1, 1), 1.1)));
      place = glm::scale(place, {number(0.3, 1), number(0.3, 1) * (i % 5 == 0 ? -1 : 1), number(0.5, 1)});
      add({{-1, -1, 0.2f}, {1, -1, -0.1f}, {1, 1, 0.3f}, {-1, 1, 0}}, {0, 1, 2, 0, 2, 3}, m, place);
    }
  }

  // backs: those of materials that are not double sided too.
  SurfacesMet hits(const DoubleRay& ray, double near, double far, bool backs = false) const {
    SurfacesMet found;
    for (const Triangle& t : triangles_) {
      const glm::dvec3 e1 = t.corners[1] - t.corners[0], e2 = t.corners[2] - t.corners[0];
      const glm::dvec3 n = glm::cross(e1, e2), to = t.corners[0] - ray.origin;
      const double across = glm::dot(n, ray.direction);
      const double distance = glm::dot(n, to) / across;
      const glm::dvec3 p = ray.direction * distance - to;
      const double v = glm::dot(glm::cross(e1, p), n) / glm::dot(n, n), u = glm::dot(glm::cross(p, e2), n) / glm::dot(n, n);
      const double inside = std::min({u, v, 1.0 - u - v});
      if (!(distance > 0.0)) continue;
      found.margin = std::min({found.margin, std::abs(inside), std::abs(distance - near), std::abs(distance - far)});
      if (inside < 0.0 || distance < near || distance > far) continue;
      const bool front = (across < 0.0) != t.mirrored;
      if (!front && !t.double_sided && !backs) continue;
      const sideray_surface_face face = front ? SIDERAY_FACE_FRONT : t.double_sided ? SIDERAY_FACE_BACK : SIDERAY_FACE_HIDDEN_BACK;
      found.all.push_back({distance, t.surface, t.primitive, t.translucent, glm::normalize(across < 0.0 ? n : -n), face, t.kind});
    }
    std::sort(found.all.begin(), found.all.end(),
              [](const SurfaceMet& a, const SurfaceMet& b) { return a.distance < b.distance; });
    for (size_t i = 1; i < found.all.size(); ++i)
      if (found.all[i].surface != found.all[i - 1].surface)
        found.margin = std::min(found.margin, found.all[i].distance / found.all[i - 1].distance - 1.0);
    return found;
  }

  TestScene scene;

 private:
  struct Triangle {
    uint32_t surface, primitive;
    bool translucent, double_sided, mirrored;
    sideray_surface_kind kind;
    glm::dvec3 corners[3];
  };
  std::vector<Triangle> triangles_;
};

// A camera at the origin that looks along -z, and its rays in double precision; y is counted from the bottom.
struct BruteCamera {
  uint32_t width, height;
  bool orthographic = false;
  double extent = 0.6, near = 0.1, far = 50.0;  // extent: tangent of half the angle, or half the height

  double aspect() const { return static_cast<double>(width) / height; }
  DoubleRay ray(double x, double y) const {
    const double s = (2 * x / width - 1) * extent * aspect(), t = (2 * y / height - 1) * extent;
    if (orthographic) return {{s, t, -near}, {0, 0, -1}};
    return {glm::dvec3(0.0), glm::normalize(glm::dvec3(s, t, -1))};
  }
  double ray_near(const DoubleRay& r) const { return orthographic ? 0.0 : near / -r.direction.z; }
  double ray_far(const DoubleRay& r) const { return (orthographic ? far - near : far) / -r.direction.z; }
  // In pixels, from the bottom left.
  glm::dvec2 place(glm::dvec3 p) const {
    const double w = orthographic ? 1.0 : -p.z;
    return {(p.x / w / (extent * aspect()) + 1) / 2 * width, (p.y / w / extent + 1) / 2 * height};
  }
  TraceView view() const {
    const double f = 1.0 / extent, range = far - near;
    TraceView v;
    v.reversed_depth = v.zero_to_one_depth = true;
    v.clip_from_local =
        orthographic ? glm::dmat4(f / aspect(), 0, 0, 0, 0, f, 0, 0, 0, 0, 1 / range, 0, 0, 0, far / range, 1)
                     : glm::dmat4(f / aspect(), 0, 0, 0, 0, f, 0, 0, 0, 0, near / range, -1, 0, 0, near * far / range, 0);
    v.local_from_clip = glm::inverse(v.clip_from_local);
    return v;
  }
};

}  // namespace sideray::rt::test
