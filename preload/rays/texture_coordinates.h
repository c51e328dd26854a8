// Computes texture coordinates as the fixed function does: generated, and multiplied by a matrix.
#pragma once

#include "preload/capture/draw_state.h"
#include "preload/capture/geometry.h"

namespace sideray::run {

// Returns a hash of the state on which a unit's coordinates depend; 0 = the vertices' own coordinates are used.
uint64_t hash_of_coordinates(const DrawState& state, int unit);

// Writes the coordinates (s, t) of a unit into u and v of each vertex's `uv[unit]`.
void make_coordinates(const DrawState& state, int unit, std::vector<Vertex>& vertices);

}  // namespace sideray::run
