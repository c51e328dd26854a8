#include "model/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "model/failure.h"

namespace sideray::model {
namespace {

constexpr float largest_coordinate = 1e15f;

template <int N>
using Vector = glm::vec<N, float>;

template <int N>
Vector<N> read(const sideray_attribute& attribute, size_t vertex) {
  const size_t stride = attribute.stride_bytes ? attribute.stride_bytes : N * sizeof(float);
  Vector<N> value;
  std::memcpy(&value, reinterpret_cast<const char*>(attribute.data) + vertex * stride, sizeof(value));
  return value;
}

template <int N>
bool finite(const Vector<N>& v) {
  for (int i = 0; i < N; ++i)
    if (!std::isfinite(v[i])) return false;
  return true;
}

// Returns the bytes of a vertex's colour as 0..1.
glm::vec4 read_bytes(const sideray_mesh_desc& d, size_t vertex) {
  const uint8_t* bytes = d.color_bytes + vertex * (d.color_bytes_stride ? d.color_bytes_stride : 4);
  const glm::vec4 color = glm::vec4(bytes[0], bytes[1], bytes[2], bytes[3]) / 255.0f;
  return d.color_bytes_bgra ? glm::vec4(color.z, color.y, color.x, color.w) : color;
}

// Limits attributes like coordinates, so that products of two stay in the range of floats.
template <int N>
bool in_range(const Vector<N>& v) {
  for (int i = 0; i < N; ++i)
    if (!(std::abs(v[i]) <= largest_coordinate)) return false;
  return true;
}

// Returns every vertex's value, or `fallback` where the attribute is absent or out of range.
template <int N>
std::vector<Vector<N>> read_all(const sideray_attribute& attribute, size_t count, Vector<N> fallback) {
  std::vector<Vector<N>> values(count, fallback);
  if (!attribute.data) return values;
  for (size_t i = 0; i < count; ++i)
    if (const Vector<N> v = read<N>(attribute, i); in_range<N>(v)) values[i] = v;
  return values;
}

void check_attribute(const sideray_attribute& attribute, const char* name, size_t components) {
  if (attribute.stride_bytes != 0 && attribute.stride_bytes < components * sizeof(float))
    fail(SIDERAY_INVALID_ARGUMENT, "mesh attribute {}: stride of {} bytes is below the {} of one entry; give 0 or more",
         name, attribute.stride_bytes, components * sizeof(float));
}

void check_attributes(const sideray_mesh_desc& d) {
  if (!d.positions.data) fail(SIDERAY_INVALID_ARGUMENT, "mesh positions: NULL; they are required");
  check_attribute(d.positions, "positions", 3);
  check_attribute(d.normals, "normals", 3);
  check_attribute(d.tangents, "tangents", 4);
  check_attribute(d.uv0, "uv0", 2);
  check_attribute(d.uv1, "uv1", 2);
  check_attribute(d.colors, "colors", 4);
  if (d.colors.data && d.color_bytes)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh colors: given as floats and as bytes; leave one of them out");
  if (d.color_bytes_stride != 0 && d.color_bytes_stride < 4)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh color_bytes_stride: {} bytes is below the 4 of one colour; give 0 or more",
         d.color_bytes_stride);
}

// Returns the vertices of a triangle, line or point.
uint32_t corners_of(sideray_topology topology) {
  return topology == SIDERAY_POINTS ? 1 : topology == SIDERAY_LINES ? 2 : 3;
}

void check_topology(const sideray_mesh_desc& d) {
  int topology;  // from a C host, so it may be no value of the enumeration
  std::memcpy(&topology, &d.topology, sizeof(topology));
  if (topology < SIDERAY_TRIANGLES || topology > SIDERAY_POINTS)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh topology {}: give a sideray_topology", topology);
}

void check(const sideray_mesh_desc& d) {
  check_topology(d);
  if (d.vertex_count == 0 || d.vertex_count > 0x7fffffffu)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh vertex_count {}: out of range; give 1 to 2^31-1", d.vertex_count);
  check_attributes(d);
  const uint32_t corners = corners_of(d.topology);
  if (d.index_count % corners != 0 || (d.index_count == 0 && d.vertex_count % corners != 0))
    fail(SIDERAY_INVALID_ARGUMENT, "mesh: {} indices over {} vertices are not whole {}", d.index_count, d.vertex_count,
         corners == 3 ? "triangles" : "lines");
  if (d.indices && d.short_indices)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh indices: given with 32 bits and with 16; leave one of them out");
  if (d.index_count != 0 && !d.indices && !d.short_indices)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh indices: NULL, although index_count is {}", d.index_count);
}

// Returns the vertices of a primitive; lines and points repeat the last one.
glm::uvec3 corner_indices(const sideray_mesh_desc& d, uint32_t primitive) {
  const uint32_t corners = corners_of(d.topology);
  glm::uvec3 indices;
  for (uint32_t k = 0; k < 3; ++k) {
    const uint32_t i = corners * primitive + std::min(k, corners - 1);
    indices[static_cast<int>(k)] = d.short_indices ? d.short_indices[i] : d.indices ? d.indices[i] : i;
  }
  return indices;
}

// Returns whether a primitive's corners are usable: finite, in range, and triangles with area.
bool usable(const std::vector<glm::vec3>& positions, glm::uvec3 t, sideray_topology topology) {
  for (int i = 0; i < 3; ++i) {
    const glm::vec3 p = positions[t[i]];
    if (!finite<3>(p) || glm::any(glm::greaterThan(glm::abs(p), glm::vec3(largest_coordinate)))) return false;
  }
  if (topology != SIDERAY_TRIANGLES) return true;
  const glm::dvec3 a(positions[t[0]]), b(positions[t[1]]), c(positions[t[2]]);
  const glm::dvec3 n = glm::cross(b - a, c - a);
  return glm::dot(n, n) > 0.0;
}

std::vector<glm::vec3> raw_positions(const sideray_mesh_desc& d) {
  std::vector<glm::vec3> positions(d.vertex_count);
  for (uint32_t i = 0; i < d.vertex_count; ++i) positions[i] = read<3>(d.positions, i);
  return positions;
}

void select_triangles(const sideray_mesh_desc& d, Mesh& mesh) {
  const uint32_t count = (d.index_count ? d.index_count : d.vertex_count) / corners_of(d.topology);
  mesh.triangles.reserve(count);
  std::vector<uint32_t> source;
  source.reserve(count);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::uvec3 t = corner_indices(d, i);
    if (glm::any(glm::greaterThanEqual(t, glm::uvec3(d.vertex_count))))
      fail(SIDERAY_INVALID_ARGUMENT, "mesh triangle {}: index {} is not below vertex_count {}; correct the indices", i,
           std::max({t.x, t.y, t.z}), d.vertex_count);
    if (!usable(mesh.positions, t, d.topology)) continue;
    mesh.triangles.push_back(t);
    source.push_back(i);
  }
  if (source.size() != count) mesh.source_primitive = std::move(source);
}

// Prepares flat shading: every corner becomes a vertex with the normal of its triangle.
void split_into_flat_triangles(Mesh& mesh) {
  Mesh flat = mesh;
  const size_t corners = mesh.triangles.size() * 3;
  const auto spread = [&](auto& to, const auto& from) {
    to.resize(corners);
    for (size_t i = 0; i < corners; ++i) to[i] = from[mesh.triangles[i / 3][static_cast<int>(i % 3)]];
  };
  spread(flat.positions, mesh.positions);
  spread(flat.tangents, mesh.tangents);
  spread(flat.uv0, mesh.uv0);
  spread(flat.uv1, mesh.uv1);
  spread(flat.colors, mesh.colors);
  flat.normals.resize(corners);
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    flat.triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
    const glm::dvec3 a(flat.positions[3 * i]), b(flat.positions[3 * i + 1]), c(flat.positions[3 * i + 2]);
    const glm::dvec3 across = glm::cross(b - a, c - a);
    // A triangle lacks area only if its vertices were moved that way.
    const glm::vec3 n(glm::dot(across, across) > 0.0 ? glm::normalize(across) : glm::dvec3(0, 0, 1));
    for (uint32_t k = 0; k < 3; ++k) flat.normals[3 * i + k] = n;
  }
  mesh = std::move(flat);
}

// Derives per-vertex tangents from uv gradients (Lengyel's accumulation), for meshes without tangents.
void derive_tangents(Mesh& mesh) {
  std::vector<glm::vec3> along_u(mesh.positions.size(), glm::vec3(0)), along_v(mesh.positions.size(), glm::vec3(0));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 e1 = mesh.positions[t.y] - mesh.positions[t.x], e2 = mesh.positions[t.z] - mesh.positions[t.x];
    const glm::vec2 d1 = mesh.uv0[t.y] - mesh.uv0[t.x], d2 = mesh.uv0[t.z] - mesh.uv0[t.x];
    const float determinant = d1.x * d2.y - d2.x * d1.y;
    if (std::abs(determinant) < 1e-20f) continue;
    const glm::vec3 u = (e1 * d2.y - e2 * d1.y) / determinant, v = (e2 * d1.x - e1 * d2.x) / determinant;
    if (!finite<3>(u) || !finite<3>(v)) continue;
    for (int k = 0; k < 3; ++k) along_u[t[k]] += u, along_v[t[k]] += v;
  }
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3 n = mesh.normals[i], t = along_u[i] - n * glm::dot(n, along_u[i]);
    const float size = glm::length(t);
    if (!(size > 1e-12f) || !std::isfinite(size)) continue;
    // glTF images grow downward in v, so the bitangent of a normal map's +Y points against the gradient of v.
    const float sign = glm::dot(glm::cross(n, t), along_v[i]) > 0 ? -1.0f : 1.0f;
    mesh.tangents[i] = glm::vec4(t / size, sign);
  }
}

void normalize_normals(Mesh& mesh) {
  for (glm::vec3& n : mesh.normals) {
    const float size = glm::length(n);
    n = size > 1e-12f && std::isfinite(size) ? n / size : glm::vec3(0, 0, 1);
  }
}

// Fills everything but positions and triangles, which the mesh already has.
void fill_attributes(const sideray_mesh_desc& d, Mesh& mesh) {
  mesh.normals = read_all<3>(d.normals, d.vertex_count, glm::vec3(0, 0, 1));
  mesh.tangents = read_all<4>(d.tangents, d.vertex_count, glm::vec4(0));
  mesh.uv0 = read_all<2>(d.uv0, d.vertex_count, glm::vec2(0));
  mesh.uv1 = read_all<2>(d.uv1, d.vertex_count, glm::vec2(0));
  mesh.colors = read_all<4>(d.colors, d.vertex_count, glm::vec4(1));
  for (size_t i = 0; d.color_bytes && i < d.vertex_count; ++i) mesh.colors[i] = read_bytes(d, i);
  mesh.has_colors = d.colors.data || d.color_bytes;
  if (mesh.has_colors)
    for (const glm::vec4& c : mesh.colors) mesh.minimum_alpha = std::min(mesh.minimum_alpha, c.w);
  if (d.normals.data)
    normalize_normals(mesh);
  else if (mesh.topology == SIDERAY_TRIANGLES)
    split_into_flat_triangles(mesh);
  if (!d.tangents.data && d.uv0.data) derive_tangents(mesh);
  mesh.has_tangents = d.tangents.data || d.uv0.data;
  for (const glm::uvec3& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) mesh.bounds.add(mesh.positions[t[k]]);
}

}  // namespace

std::shared_ptr<const Mesh> build_mesh(const sideray_mesh_desc& d, uint32_t* dropped, MeshForm& form) {
  check(d);
  auto mesh = std::make_shared<Mesh>();
  mesh->topology = d.topology;
  mesh->positions = raw_positions(d);
  select_triangles(d, *mesh);
  for (glm::vec3& p : mesh->positions)
    if (!finite<3>(p)) p = glm::vec3(0);  // no triangle uses it any more
  form = {d.vertex_count, d.normals.data != nullptr, {}};
  if (!form.has_normals) form.corners = mesh->triangles;
  fill_attributes(d, *mesh);
  const uint32_t given = (d.index_count ? d.index_count : d.vertex_count) / corners_of(d.topology);
  if (dropped) *dropped = given - static_cast<uint32_t>(mesh->triangles.size());
  return mesh;
}

std::shared_ptr<const Mesh> build_moved_mesh(const Mesh& mesh, const MeshForm& form, const sideray_mesh_desc& d) {
  check_attributes(d);
  if (d.vertex_count != form.vertex_count)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh vertex_count {}: the mesh has {} vertices; give as many, or add another mesh",
         d.vertex_count, form.vertex_count);
  if ((d.normals.data != nullptr) != form.has_normals)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh normals: the mesh was added {} them; give it vertices of the same kind",
         form.has_normals ? "with" : "without");
  auto moved = std::make_shared<Mesh>();
  moved->topology = mesh.topology;
  moved->positions.reserve(size_t{d.vertex_count} + 1);  // Embree reads 16 bytes at the last vertex
  moved->positions.resize(d.vertex_count);
  for (uint32_t i = 0; i < d.vertex_count; ++i) {
    const glm::vec3 p = read<3>(d.positions, i);
    if (!in_range<3>(p))
      fail(SIDERAY_INVALID_ARGUMENT, "mesh vertex {}: ({}, {}, {}) is not finite or beyond 1e15; correct it", i, p.x,
           p.y, p.z);
    moved->positions[i] = p;
  }
  moved->triangles = form.has_normals ? mesh.triangles : form.corners;
  moved->source_primitive = mesh.source_primitive;
  fill_attributes(d, *moved);
  return moved;
}

bool same_triangles(const Mesh& a, const Mesh& b) {
  return a.topology == b.topology && a.positions.size() == b.positions.size() && a.triangles == b.triangles;
}

const Mesh* shaped_before(const Snapshot& now, uint32_t index, const Snapshot& before) {
  const uint32_t was = find_name(before.mesh_names, before.meshes.size(), now.mesh_names[index]);
  if (was == no_index || before.meshes[was] == now.meshes[index]) return nullptr;
  return same_triangles(*before.meshes[was], *now.meshes[index]) ? before.meshes[was].get() : nullptr;
}

const Instance* elsewhere_before(const Snapshot& now, uint32_t index, const Snapshot& before, bool shaped) {
  const uint32_t was = find_name(before.instance_names, before.instances.size(), now.instance_names[index]);
  if (was == no_index) return nullptr;
  const Instance &instance = now.instances[index], &then = before.instances[was];
  const bool same_mesh = now.mesh_names[instance.mesh] == before.mesh_names[then.mesh];
  return same_mesh && (shaped || then.local_from_object != instance.local_from_object) ? &then : nullptr;
}

}  // namespace sideray::model
