#include "rt/textures/alpha_grid.h"

#include <algorithm>
#include <vector>

namespace sideray::rt {
namespace {

// Returns the texels of one axis that look-ups in a cell may read: its own and one more on each side, which at the
// picture's ends wraps around.
std::vector<uint32_t> texels_of(uint32_t cell, uint32_t cell_size, uint32_t size) {
  const uint32_t first = cell * cell_size, end = std::min(first + cell_size, size);
  std::vector<uint32_t> texels;
  for (uint32_t i = first; i < end; ++i) texels.push_back(i);
  texels.push_back(first > 0 ? first - 1 : size - 1);
  texels.push_back(end < size ? end : 0);
  return texels;
}

}  // namespace

AlphaGrid::AlphaGrid(const model::Texture::Level& level)
    : width_(level.width), height_(level.height), across_((width_ + cell - 1) / cell) {
  const uint32_t down = (height_ + cell - 1) / cell;
  cells_.assign(size_t{across_} * down, {255, 0});
  std::vector<std::vector<uint32_t>> columns_of(across_);
  for (uint32_t i = 0; i < across_; ++i) columns_of[i] = texels_of(i, cell, width_);
  for (uint32_t j = 0; j < down; ++j) {
    const std::vector<uint32_t> rows = texels_of(j, cell, height_);
    for (uint32_t i = 0; i < across_; ++i) {
      AlphaBounds& bounds = cells_[size_t{j} * across_ + i];
      for (const uint32_t y : rows)
        for (const uint32_t x : columns_of[i]) {
          const uint8_t alpha = level.rgba[4 * (size_t{y} * width_ + x) + 3];
          bounds = {std::min(bounds.least, alpha), std::max(bounds.most, alpha)};
        }
    }
  }
}

}  // namespace sideray::rt
