// What one draw gives OpenGL: vertices and how they are joined.
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

// What of vertices counts besides their positions: the other attributes are those that the program used last, for whatever.
struct Counted {
  bool colors = true, normals = true;
  unsigned units = (1u << kept_units) - 1;  // bit i: the coordinates of unit i

  unsigned key() const { return (colors ? 1u : 0u) + (normals ? 2u : 0u) + 4 * units; }
};

struct Geometry {
  GLenum mode = GL_TRIANGLES;
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;  // empty = one vertex after the other
  mutable std::vector<std::pair<unsigned, uint64_t>> hashes;  // that hash_of() has found, by Counted::key()

  size_t count() const { return indices.empty() ? vertices.size() : indices.size(); }
  // Whether no vertex is translucent.
  bool is_opaque() const;
  bool is_surface() const { return mode >= GL_TRIANGLES && count() >= 3; }
};

// Indices of three vertices a triangle. OpenGL's order, so that the front face stays the front face.
std::vector<uint32_t> triangles_of(const Geometry& geometry);

// Names the geometry: what of it counts, and how it is joined.
uint64_t hash_of(const Geometry& geometry, const Counted& counted);

// Draws it by the driver, with the arrays of the fixed function. Changes client state and the current attributes.
void draw(const Geometry& geometry);

}  // namespace sideray::run
