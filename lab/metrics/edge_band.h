// Measures errors near the edges of layers, where caches of a reduced rate are at their worst. Plain memory; any thread
// may call it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sideray::lab {

// Returns 1 for pixels within `reach` pixels (along x and along y) of an edge, where the surface ids of two adjacent
// pixels differ in some layer. `layers` holds a picture of surface ids for each layer.
std::vector<uint8_t> edge_band(std::span<const std::vector<uint32_t>> layers, uint32_t width, uint32_t height,
                               uint32_t reach);

// Returns the mean of the values inside or outside the band; 0 where it has no such pixels.
double mean_over(std::span<const float> values, std::span<const uint8_t> band, bool inside);

}  // namespace sideray::lab
