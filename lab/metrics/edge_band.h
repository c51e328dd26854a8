// Measures errors near the edges of layers, where caches at a reduced rate have their largest errors. Plain memory; any
// thread may call it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sideray::lab {

// Returns 1 for pixels at most `reach` pixels (along x and along y) from an edge, which is between two horizontal or
// vertical neighbours with different surface ids in some layer. `layers`: one picture of ids for each layer.
std::vector<uint8_t> edge_band(std::span<const std::vector<uint32_t>> layers, uint32_t width, uint32_t height,
                               uint32_t reach);

// Returns the mean of the values where `band` equals `inside`; 0 if it does so nowhere.
double mean_over(std::span<const float> values, std::span<const uint8_t> band, bool inside);

}  // namespace sideray::lab
