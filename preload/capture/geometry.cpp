#include "preload/capture/geometry.h"

#include <algorithm>

#include "preload/base/hash.h"
#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

// Calls f(a, b, c) for each triangle of a primitive of `count` vertices; a, b and c are positions in their order.
template <typename F>
void for_each_triangle(GLenum mode, uint32_t count, F&& f) {
  switch (mode) {
    case GL_TRIANGLES:
      for (uint32_t i = 0; i + 2 < count; i += 3) f(i, i + 1, i + 2);
      break;
    case GL_TRIANGLE_STRIP:
      for (uint32_t i = 0; i + 2 < count; ++i) i % 2 == 0 ? f(i, i + 1, i + 2) : f(i + 1, i, i + 2);
      break;
    case GL_QUADS:
      for (uint32_t i = 0; i + 3 < count; i += 4) f(i, i + 1, i + 2), f(i, i + 2, i + 3);
      break;
    case GL_QUAD_STRIP:
      for (uint32_t i = 0; i + 3 < count; i += 2) f(i, i + 1, i + 3), f(i, i + 3, i + 2);
      break;
    case GL_TRIANGLE_FAN:
    case GL_POLYGON:
      for (uint32_t i = 1; i + 1 < count; ++i) f(0u, i, i + 1);
      break;
    default:
      break;
  }
}

void set_unit(const Functions& gl, int unit, const Vertex& first) {
  gl.ClientActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl.EnableClientState(GL_TEXTURE_COORD_ARRAY);
  gl.TexCoordPointer(4, GL_FLOAT, sizeof(Vertex), first.uv[unit]);
}

void disable_other_units(const Functions& gl) {
  for (GLenum unit = kept_units; unit < 8; ++unit) {
    gl.ClientActiveTexture(GL_TEXTURE0 + unit);
    gl.DisableClientState(GL_TEXTURE_COORD_ARRAY);
  }
}

}  // namespace

bool Geometry::is_opaque() const {
  return std::all_of(vertices.begin(), vertices.end(), [](const Vertex& vertex) { return vertex.color[3] >= 0.99f; });
}

std::vector<uint32_t> triangles_of(const Geometry& geometry) {
  std::vector<uint32_t> triangles;
  const auto vertex = [&](uint32_t place) { return geometry.indices.empty() ? place : geometry.indices[place]; };
  for_each_triangle(geometry.mode, static_cast<uint32_t>(geometry.count()), [&](uint32_t a, uint32_t b, uint32_t c) {
    triangles.insert(triangles.end(), {vertex(a), vertex(b), vertex(c)});
  });
  return triangles;
}

uint64_t hash_of(const Geometry& geometry, const Counted& counted) {
  for (const auto& [key, hash] : geometry.hashes)
    if (key == counted.key()) return hash;
  uint64_t hash = mix(geometry.mode, counted.key());
  for (const Vertex& vertex : geometry.vertices) {
    hash = hash_bytes(vertex.position, sizeof(vertex.position), hash);
    for (unsigned unit = 0; unit < kept_units; ++unit)
      if (counted.units & (1u << unit)) hash = hash_bytes(vertex.uv[unit], sizeof(vertex.uv[unit]), hash);
    if (counted.normals) hash = hash_bytes(vertex.normal, sizeof(vertex.normal), hash);
    if (counted.colors) hash = hash_bytes(vertex.color, sizeof(vertex.color), hash);
  }
  hash = hash_bytes(geometry.indices.data(), geometry.indices.size() * sizeof(uint32_t), hash);
  geometry.hashes.emplace_back(counted.key(), hash);
  return hash;
}

void draw(const Geometry& geometry) {
  if (geometry.vertices.empty()) return;
  const Functions& gl = real();
  const Vertex& first = geometry.vertices.front();
  if (gl.BindBuffer) gl.BindBuffer(GL_ARRAY_BUFFER, 0), gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
  for (const GLenum array : {GLenum{GL_INDEX_ARRAY}, GLenum{GL_EDGE_FLAG_ARRAY}, GLenum{GL_FOG_COORD_ARRAY}, GLenum{GL_SECONDARY_COLOR_ARRAY}})
    gl.DisableClientState(array);
  for (const GLenum array : {GLenum{GL_VERTEX_ARRAY}, GLenum{GL_NORMAL_ARRAY}, GLenum{GL_COLOR_ARRAY}}) gl.EnableClientState(array);
  gl.VertexPointer(4, GL_FLOAT, sizeof(Vertex), first.position);
  gl.NormalPointer(GL_FLOAT, sizeof(Vertex), first.normal);
  gl.ColorPointer(4, GL_FLOAT, sizeof(Vertex), first.color);
  disable_other_units(gl);
  for (int unit = texture_units(); unit-- > 0;) set_unit(gl, unit, first);
  const auto count = static_cast<GLsizei>(geometry.count());
  if (geometry.indices.empty())
    gl.DrawArrays(geometry.mode, 0, count);
  else
    gl.DrawElements(geometry.mode, count, GL_UNSIGNED_INT, geometry.indices.data());
}

}  // namespace sideray::run
