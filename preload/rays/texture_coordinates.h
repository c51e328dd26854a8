// Texture coordinates as the fixed function makes them of a vertex: generated, and multiplied by a matrix.
#pragma once

#include "preload/capture/draw_state.h"
#include "preload/capture/geometry.h"

namespace sideray::run {

// What of OpenGL's state the coordinates of a unit depend on; 0 = on nothing, they are those of the vertices.
uint64_t hash_of_coordinates(const DrawState& state, int unit);

// Writes the coordinates (s, t) of a unit into u and v of each vertex's `uv[unit]`.
void make_coordinates(const DrawState& state, int unit, std::vector<Vertex>& vertices);

}  // namespace sideray::run
