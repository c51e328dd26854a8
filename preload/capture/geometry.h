// The vertices of one draw and the primitives that they form.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "preload/gl/functions.h"

namespace sideray::run {

struct Vertex {
  float position[4] = {0, 0, 0, 1};
  float color[4] = {1, 1, 1, 1};
  float uv[kept_units][4] = {{0, 0, 0, 1}, {0, 0, 0, 1}, {0, 0, 0, 1}, {0, 0, 0, 1}};
  float normal[3] = {0, 0, 1};
};

// Says which attributes of vertices count besides positions. Others are left over from what the program used last.
struct Counted {
  bool colors = true, normals = true;
  unsigned units = (1u << kept_units) - 1;  // bit i: the coordinates of unit i

  unsigned key() const { return (colors ? 1u : 0u) + (normals ? 2u : 0u) + 4 * units; }
};

struct Geometry {
  GLenum mode = GL_TRIANGLES;
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;  // empty = the vertices in order
  mutable std::vector<std::pair<unsigned, uint64_t>> hashes;  // cached results of hash_of(), by Counted::key()

  size_t count() const { return indices.empty() ? vertices.size() : indices.size(); }
  // Returns whether no vertex is translucent.
  bool is_opaque() const;
  bool is_surface() const { return mode >= GL_TRIANGLES && count() >= 3; }
};

// Returns three indices per triangle, in OpenGL's order, so that front faces stay front faces.
std::vector<uint32_t> triangles_of(const Geometry& geometry);

// Returns a hash of positions, attributes that count, and primitives.
uint64_t hash_of(const Geometry& geometry, const Counted& counted);

// Draws the geometry with the fixed function's arrays. Changes client state and the current attributes.
void draw(const Geometry& geometry);

}  // namespace sideray::run
