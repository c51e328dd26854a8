#include "rt/reach/wanted_tiles.h"

#include <algorithm>

namespace sideray::rt {

std::vector<uint8_t> grown(const std::vector<uint8_t>& tiles, uint32_t columns, uint32_t by) {
  const auto rows = static_cast<uint32_t>(tiles.size() / columns);
  std::vector<uint8_t> result(tiles.size(), 0);
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t column = 0; column < columns; ++column) {
      if (!tiles[size_t{row} * columns + column]) continue;
      for (uint32_t v = row - std::min(row, by); v < std::min(row + by + 1, rows); ++v)
        for (uint32_t u = column - std::min(column, by); u < std::min(column + by + 1, columns); ++u)
          result[size_t{v} * columns + u] = 1;
    }
  return result;
}

std::vector<uint8_t> traced_tiles(const WantedTiles* wanted, uint32_t width, uint32_t read_around) {
  if (!wanted || wanted->tiles.empty()) return {};
  return grown(wanted->tiles, tile_count(width), read_around);
}

}  // namespace sideray::rt
