// Bounds a texture's alpha over cells of its texels: the bounds decide most of a cut-out, in a thirtieth of the texels'
// memory. Depends only on model/. Immutable; any thread may read it.
#pragma once

#include <cstdint>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

struct AlphaBounds {
  uint8_t least, most;  // as stored in the texture
};

class AlphaGrid {
 public:
  explicit AlphaGrid(const model::Texture::Level& level);

  // Bounds the texels that a look-up in the finest level may read there, for every filter and wrap mode. Texel
  // coordinates are in [0, size], or [0, 2 size] for mirrored textures.
  AlphaBounds at(float x, float y) const { return cells_[row(y) * across_ + column(x)]; }

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }

 private:
  static constexpr uint32_t cell = 4;
  static uint32_t cell_of(float x, uint32_t size) {
    const auto i = static_cast<uint32_t>(x);
    const uint32_t unfolded = i < size ? i : 2 * size - 1 - i;
    // The end of the range reads the last texel, or the first for a mirrored texture.
    return (unfolded < size ? unfolded : (i == size ? size - 1 : 0)) / cell;
  }
  uint32_t column(float x) const { return cell_of(x, width_); }
  uint32_t row(float y) const { return cell_of(y, height_); }

  uint32_t width_, height_, across_;
  std::vector<AlphaBounds> cells_;
};

}  // namespace sideray::rt
