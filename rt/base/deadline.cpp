#include "rt/base/deadline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace sideray::rt {
namespace {

// A pixel with this many surfaces ranks like a pixel with none that is half the picture's radius nearer to the middle.
constexpr float many_layers = 8.0f;

// Returns 0 in the middle of the picture, 1 in its corners.
float distance_from_middle(float x, float y, float width, float height) {
  const float u = 2.0f * x / width - 1.0f, v = 2.0f * y / height - 1.0f;
  return std::sqrt((u * u + v * v) * 0.5f);
}

// Sorts by ranks of -1/2 to 1, in 512 steps. Differences below a step do not matter, and a counting sort takes next to
// no time, however many pieces there are.
std::vector<uint32_t> sorted_by(const std::vector<float>& ranks) {
  constexpr size_t steps = 512;
  const auto step = [](float rank) { return std::min(static_cast<size_t>((rank + 0.5f) * (steps / 1.5f)), steps - 1); };
  std::array<uint32_t, steps + 1> first{};
  for (const float rank : ranks) ++first[step(rank) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<uint32_t> order(ranks.size());
  for (uint32_t i = 0; i < ranks.size(); ++i) order[first[step(ranks[i])]++] = i;
  return order;
}

}  // namespace

std::vector<uint32_t> order_of_importance(std::span<const PixelRequest> pixels, std::span<const uint32_t> starts,
                                          uint32_t width, uint32_t height) {
  std::vector<float> ranks;
  for (size_t i = 0; i + 1 < starts.size(); ++i) {
    // A chunk's middle pixel represents it, because its pixels are neighbours.
    const PixelRequest& p = pixels[starts[i] + (starts[i + 1] - starts[i]) / 2];
    const float layers = p.layers == unlimited_layers ? many_layers : static_cast<float>(p.layers);
    ranks.push_back(distance_from_middle(static_cast<float>(p.x) + 0.5f, static_cast<float>(p.y) + 0.5f,
                                         static_cast<float>(width), static_cast<float>(height)) -
                    0.5f * std::min(layers, many_layers) / many_layers);
  }
  return sorted_by(ranks);
}

std::vector<uint32_t> order_of_importance(uint32_t tile_columns, uint32_t tile_rows) {
  std::vector<float> ranks;
  for (uint32_t row = 0; row < tile_rows; ++row)
    for (uint32_t column = 0; column < tile_columns; ++column)
      ranks.push_back(distance_from_middle(static_cast<float>(column) + 0.5f, static_cast<float>(row) + 0.5f,
                                           static_cast<float>(tile_columns), static_cast<float>(tile_rows)));
  return sorted_by(ranks);
}

void order_by_turns(std::span<const uint32_t> last_turns, std::vector<uint32_t>& order) {
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return last_turns[a] < last_turns[b]; });
}

}  // namespace sideray::rt
