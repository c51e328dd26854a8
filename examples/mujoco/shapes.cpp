#include "shapes.h"

#include <array>
#include <cmath>
#include <functional>

namespace {

using Vector = std::array<float, 3>;

struct Vertex {
  Vector position, normal;
};

void add(Shape& shape, const Vertex& v) {
  shape.positions.insert(shape.positions.end(), v.position.begin(), v.position.end());
  shape.normals.insert(shape.normals.end(), v.normal.begin(), v.normal.end());
}

void add_quad(Shape& shape, const std::array<Vertex, 4>& v) {
  for (const size_t k : {0u, 1u, 2u, 0u, 2u, 3u}) add(shape, v[k]);
}

// Adds quads between rings; `at` returns the vertex at a turn and a height, both 0..1, counter-clockwise from outside.
void add_turned(Shape& shape, int slices, int rings, const std::function<Vertex(float, float)>& at) {
  const auto vertex = [&](int i, int j) {
    return at(static_cast<float>(i % slices) / static_cast<float>(slices), static_cast<float>(j) / static_cast<float>(rings));
  };
  for (int j = 0; j < rings; ++j)
    for (int i = 0; i < slices; ++i)
      add_quad(shape, {vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
}

constexpr int slices = 64, rings = 32;
constexpr float pi = 3.14159265f;

// Returns a sphere whose halves are moved apart along z.
Shape round(float radius, float half_length) {
  Shape shape;
  add_turned(shape, slices, 2 * rings, [&](float turn, float height) {
    const float azimuth = 2 * pi * turn, polar = pi * (1 - height);
    const Vector n{std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
    const float shift = height < 0.5f ? -half_length : half_length;
    return Vertex{{radius * n[0], radius * n[1], radius * n[2] + shift}, n};
  });
  if (half_length == 0.0f) return shape;
  add_turned(shape, slices, 1, [&](float turn, float height) {
    const Vector n{std::cos(2 * pi * turn), std::sin(2 * pi * turn), 0};
    return Vertex{{radius * n[0], radius * n[1], half_length * (height < 0.5f ? -1.0f : 1.0f)}, n};
  });
  return shape;
}

Shape cylinder() {
  Shape shape;
  const auto rim = [](float turn, float z, float radius) {
    return Vector{radius * std::cos(2 * pi * turn), radius * std::sin(2 * pi * turn), z};
  };
  add_turned(shape, slices, 1, [&](float turn, float height) {
    return Vertex{rim(turn, 2 * height - 1, 1), rim(turn, 0, 1)};
  });
  for (const float z : {-1.0f, 1.0f})
    add_turned(shape, slices, 1, [&](float turn, float height) {
      return Vertex{rim(turn, z, z < 0 ? height : 1 - height), {0, 0, z}};
    });
  return shape;
}

Shape box() {
  Shape shape;
  for (size_t axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const auto corner = [&](float u, float v) {
        Vertex vertex{{}, {}};
        vertex.position[axis] = vertex.normal[axis] = side;
        vertex.position[(axis + 1) % 3] = u * side, vertex.position[(axis + 2) % 3] = v;
        return vertex;
      };
      add_quad(shape, {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)});
    }
  return shape;
}

Shape plane() {
  Shape shape;
  const auto corner = [](float x, float y) { return Vertex{{x, y, 0}, {0, 0, 1}}; };
  add_quad(shape, {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)});
  for (size_t i = 0; i < shape.positions.size(); i += 3) {
    shape.uv.push_back(0.5f + 0.5f * shape.positions[i]);
    shape.uv.push_back(0.5f - 0.5f * shape.positions[i + 1]);
  }
  return shape;
}

// Returns a mesh. MuJoCo numbers drawn meshes 2 * mesh, their convex hulls 2 * mesh + 1.
Shape mesh(const mjModel& model, int mesh) {
  Shape shape;
  const int* faces = model.mesh_face + 3 * model.mesh_faceadr[mesh];
  const float* positions = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
  const float* normals = model.mesh_normal + 3 * model.mesh_vertadr[mesh];
  for (int i = 0; i < 3 * model.mesh_facenum[mesh]; ++i) {
    const float *p = positions + 3 * faces[i], *n = normals + 3 * faces[i];
    add(shape, {{p[0], p[1], p[2]}, {n[0], n[1], n[2]}});
  }
  return shape;
}

}  // namespace

bool has_shape(const mjvGeom& geom) {
  switch (geom.type) {
    case mjGEOM_MESH: return geom.dataid >= 0 && geom.dataid % 2 == 0;
    case mjGEOM_PLANE:
    case mjGEOM_SPHERE:
    case mjGEOM_CAPSULE:
    case mjGEOM_ELLIPSOID:
    case mjGEOM_CYLINDER:
    case mjGEOM_BOX: return geom.rgba[3] > 0.0f;
    default: return false;
  }
}

Shape shape_of(const mjModel& model, const mjvGeom& geom) {
  switch (geom.type) {
    case mjGEOM_PLANE: return plane();
    case mjGEOM_CAPSULE: return round(geom.size[0], geom.size[2]);
    case mjGEOM_CYLINDER: return cylinder();
    case mjGEOM_BOX: return box();
    case mjGEOM_MESH: return mesh(model, geom.dataid / 2);
    default: return round(1.0f, 0.0f);
  }
}
