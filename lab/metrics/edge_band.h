// Measures errors near the edges of layers, where caches of a reduced rate are at their worst. Plain memory; any thread
// may call it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sideray::lab {

// Returns 1 for pixels no farther than `reach` pixels (along x and along y) from an edge: two neighbours, side by side,
// whose surface ids differ in some layer. `layers`: a picture of ids each.
std::vector<uint8_t> edge_band(std::span<const std::vector<uint32_t>> layers, uint32_t width, uint32_t height,
                               uint32_t reach);

// Returns the mean of the values where `band` is `inside`; 0 where that is nowhere.
double mean_over(std::span<const float> values, std::span<const uint8_t> band, bool inside);

}  // namespace sideray::lab
