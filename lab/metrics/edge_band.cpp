#include "lab/metrics/edge_band.h"

#include <algorithm>

namespace sideray::lab {

std::vector<uint8_t> edge_band(std::span<const std::vector<uint32_t>> layers, uint32_t width, uint32_t height,
                               uint32_t reach) {
  const size_t count = size_t{width} * height;
  std::vector<uint8_t> edges(count, 0), wide(count, 0), band(count, 0);
  for (const std::vector<uint32_t>& ids : layers)
    for (size_t i = 0; i < count; ++i) {
      if ((i + 1) % width != 0 && ids[i] != ids[i + 1]) edges[i] = edges[i + 1] = 1;
      if (i + width < count && ids[i] != ids[i + width]) edges[i] = edges[i + width] = 1;
    }
  for (size_t i = 0; i < count; ++i) {
    if (!edges[i]) continue;
    const size_t x = i % width, row = i - x;
    std::fill(wide.begin() + static_cast<ptrdiff_t>(row + (x > reach ? x - reach : 0)),
              wide.begin() + static_cast<ptrdiff_t>(row + std::min<size_t>(x + reach + 1, width)), uint8_t{1});
  }
  for (size_t i = 0; i < count; ++i) {
    if (!wide[i]) continue;
    const size_t x = i % width, y = i / width;
    const size_t end = std::min<size_t>(y + reach + 1, height);
    for (size_t v = y > reach ? y - reach : 0; v < end; ++v) band[v * width + x] = 1;
  }
  return band;
}

double mean_over(std::span<const float> values, std::span<const uint8_t> band, bool inside) {
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    if ((band[i] != 0) != inside) continue;
    sum += static_cast<double>(values[i]);
    ++count;
  }
  return count ? sum / static_cast<double>(count) : 0.0;
}

}  // namespace sideray::lab
