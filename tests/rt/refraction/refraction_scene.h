// Makes convex solids in front of a wall of differently emissive tiles, and computes paths through them by Snell's law,
// in double from planes alone.
#pragma once

#include <cmath>
#include <optional>

#include "rt/refraction/refraction.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::test {

struct DoubleRay {
  glm::dvec3 origin, direction;
};

// Unit vectors, the normal against the direction; nothing where the ray is reflected totally.
inline std::optional<glm::dvec3> snell(glm::dvec3 direction, glm::dvec3 normal, double from, double to) {
  const double r = from / to, cosine = -glm::dot(direction, normal), square = 1 - r * r * (1 - cosine * cosine);
  if (square < 0) return std::nullopt;
  return glm::normalize(r * direction + (r * cosine - std::sqrt(square)) * normal);
}

// Schlick's term as glTF has it for white glass, in air.
inline double schlick(double cosine, double ior) {
  const double f0 = (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1));
  return f0 + (1 - f0) * std::pow(1 - cosine, 5);
}

// The points p with dot(normal, p) <= offset for every face.
struct ConvexSolid {
  struct Face {
    glm::dvec3 normal;
    double offset;
  };
  std::vector<Face> faces;
  double ior = 1.5;
  double fresnel_ior = 0;  // what it reflects by, where that is not the same
  glm::dvec3 absorption{0.0};

  struct Passage {
    DoubleRay out;
    glm::dvec3 transmittance;
    int surfaces;
    double from_edge;  // how near the path came to an edge of the solid
  };

  // Where a ray enters; nothing where it passes by.
  std::optional<std::pair<double, size_t>> entry(const DoubleRay& ray) const {
    double t_in = 0, t_out = 1e30;
    size_t face = faces.size();
    for (size_t i = 0; i < faces.size(); ++i) {
      const double across = glm::dot(faces[i].normal, ray.direction);
      const double t = (faces[i].offset - glm::dot(faces[i].normal, ray.origin)) / across;
      if (across < 0 && t > t_in) t_in = t, face = i;
      if (across > 0) t_out = std::min(t_out, t);
    }
    if (face == faces.size() || t_in >= t_out) return std::nullopt;
    return std::pair(t_in, face);
  }

  double edge_distance(glm::dvec3 p, size_t face) const {
    double nearest = 1e30;
    for (size_t i = 0; i < faces.size(); ++i)
      if (i != face) nearest = std::min(nearest, faces[i].offset - glm::dot(faces[i].normal, p));
    return nearest;
  }

  std::optional<Passage> pass(DoubleRay ray) const {
    const auto in = entry(ray);
    if (!in) return std::nullopt;
    const auto [t_in, face_in] = *in;
    ray.origin += t_in * ray.direction;
    const double cosine = -glm::dot(faces[face_in].normal, ray.direction);
    Passage passage{ray, glm::dvec3(1 - schlick(cosine, fresnel_ior > 0 ? fresnel_ior : ior)), 1, edge_distance(ray.origin, face_in)};
    ray.direction = *snell(ray.direction, faces[face_in].normal, 1.0, ior);
    return leave(ray, face_in, passage);
  }

  // From a point inside or on a face.
  std::optional<Passage> leave(DoubleRay ray, size_t last_face, Passage passage) const {
    for (int bounce = 0; bounce < 64; ++bounce) {
      double t = 1e30;
      size_t face = 0;
      for (size_t i = 0; i < faces.size(); ++i) {
        const double across = glm::dot(faces[i].normal, ray.direction);
        const double t_face = (faces[i].offset - glm::dot(faces[i].normal, ray.origin)) / across;
        if (i != last_face && across > 0 && t_face < t) t = t_face, face = i;
      }
      ray.origin += t * ray.direction;
      passage.transmittance *= glm::exp(-absorption * t);
      passage.from_edge = std::min(passage.from_edge, edge_distance(ray.origin, face));
      ++passage.surfaces;
      last_face = face;
      const auto out = snell(ray.direction, -faces[face].normal, ior, 1.0);
      if (!out) {
        ray.direction = glm::reflect(ray.direction, faces[face].normal);
        continue;
      }
      passage.transmittance *= 1 - schlick(glm::dot(*out, faces[face].normal), fresnel_ior > 0 ? fresnel_ior : ior);
      passage.out = {ray.origin, *out};
      return passage;
    }
    return std::nullopt;
  }
};

inline ConvexSolid box_solid(glm::dvec3 low, glm::dvec3 high) {
  ConvexSolid solid;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 n(0.0);
    n[axis] = 1;
    solid.faces.push_back({n, high[axis]});
    solid.faces.push_back({-n, -low[axis]});
  }
  return solid;
}

struct Triangles {
  std::vector<glm::vec3> positions;
  std::vector<uint32_t> indices;
  void polygon(const std::vector<glm::vec3>& corners) {
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), corners.begin(), corners.end());
    for (uint32_t i = 2; i < corners.size(); ++i) indices.insert(indices.end(), {first, first + i - 1, first + i});
  }
  // The polygon along z, counter-clockwise in x and y, from z = low to high.
  static Triangles column(const std::vector<glm::vec2>& outline, float low, float high) {
    Triangles t;
    std::vector<glm::vec3> top, bottom;
    for (const glm::vec2 p : outline) top.emplace_back(p, high), bottom.insert(bottom.begin(), glm::vec3(p, low));
    t.polygon(top), t.polygon(bottom);
    for (size_t i = 0; i < outline.size(); ++i) {
      const glm::vec2 a = outline[i], b = outline[(i + 1) % outline.size()];
      t.polygon({{a, low}, {b, low}, {b, high}, {a, high}});
    }
    return t;
  }
  static Triangles box(glm::vec3 low, glm::vec3 high) {
    return column({{low.x, low.y}, {high.x, low.y}, {high.x, high.y}, {low.x, high.y}}, low.z, high.z);
  }
  uint32_t add_to(TestScene& scene, const sideray_material_desc& material) const {
    return scene.add(positions, std::vector<glm::vec2>(positions.size()), indices, material, glm::dmat4(1.0));
  }
};

inline sideray_material_desc solid_glass(float ior, glm::vec3 color = glm::vec3(1.0f), float distance = INFINITY) {
  sideray_material_desc m = glass();
  m.ior = ior;
  m.thickness = 1.0f;
  m.attenuation_distance = distance;
  for (int c = 0; c < 3; ++c) m.attenuation_color[c] = color[c];
  return m;
}

// A square wall on z = `z`, facing +z, from -half to half; its tiles differ and none is black.
struct TiledWall {
  static constexpr uint32_t tiles = 32;
  double z, half;

  void add_to(TestScene& scene) const {
    std::vector<uint8_t> rgba;
    for (uint32_t row = 0; row < tiles; ++row)
      for (uint32_t column = 0; column < tiles; ++column)
        rgba.insert(rgba.end(), {static_cast<uint8_t>(7 + 8 * column), static_cast<uint8_t>(7 + 8 * row), 255, 255});
    sideray_material_desc m = glowing(glm::vec3(1.0f));
    m.emissive_texture.texture = scene.scene.add_texture(tiles, tiles, SIDERAY_RGBA8, rgba.data());
    m.emissive_texture.filter = SIDERAY_NEAREST;
    const auto h = static_cast<float>(half);
    scene.quad({0, 0, static_cast<float>(z)}, {h, 0, 0}, {0, h, 0}, m);
  }

  // What the ray sees of it; nothing within `margin` of a tile's edge, or beside the wall.
  std::optional<glm::dvec3> seen(const DoubleRay& ray, double margin) const {
    if (ray.direction.z > -1e-3) return std::nullopt;
    const glm::dvec3 p = ray.origin + ray.direction * ((z - ray.origin.z) / ray.direction.z);
    const double per_tile = 2 * half / tiles, s = (p.x + half) / per_tile, t = (half - p.y) / per_tile;
    if (s < 0 || t < 0 || s >= tiles || t >= tiles) return std::nullopt;
    const double edge = std::min(std::abs(s - std::round(s)), std::abs(t - std::round(t))) * per_tile;
    if (edge < margin) return std::nullopt;
    return glm::dvec3(7 + 8 * std::floor(s), 7 + 8 * std::floor(t), 255) / 255.0;
  }
};

}  // namespace sideray::rt::test
