// Holds the state of a picture's cells of 2x2 pixels, of which one pixel is traced. Plain memory; different cells may
// be written at the same time.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::rt {

inline constexpr uint32_t cell_side = 2;  // pixels

// Describes the surface at a cell's traced pixel.
struct CellPlace {
  glm::vec3 position{0.0f}, normal{0.0f};
  float width = 0.0f;  // of a pixel's footprint there, world units; 0: no surface
  float skip = 0.0f;   // as in DepthPoint
};

// Returns how well a position lies on the plane of a cell: 1 on it, 0 or less on another plane.
inline float plane_share(const CellPlace& place, glm::vec3 position) {
  constexpr float off_plane = 2.0f;  // widths of a pixel
  return 1.0f - std::abs(glm::dot(place.normal, position - place.position)) / (off_plane * place.width);
}

// Holds means over a cell's samples.
struct CellLight {
  glm::vec3 light{0.0f};  // light of surfaces, plus `tint` of directions in which the sky is visible
  // The sky's light from a sampled direction minus the same light in the mean colour. It is 0 on average, so it is a
  // control variate: the errors of its visible part and of the product of both means cancel.
  glm::vec3 tint{0.0f};
  float open = 0.0f;      // share of those directions in which the sky is visible
  float nearness = 0.0f;  // 1 / distance of the paths' first hits
  // The largest 1 / distance of those hits along the surface, as to a wall on a floor, wherever it is hit. It decays,
  // because the cell may have moved along the surface.
  float most_near = 0.0f;
  float samples = 0.0f;   // their number

  static constexpr float fading = 0.97f;

  void add(const CellLight& sample) {
    samples += 1.0f;
    const float share = 1.0f / samples;
    light += (sample.light - light) * share;
    tint += (sample.tint - tint) * share;
    open += (sample.open - open) * share;
    nearness += (sample.nearness - nearness) * share;
    most_near = std::max(most_near * fading, sample.most_near);
  }
};

// A range of rows of the picture, or of its cells.
struct PixelRows {
  uint32_t first = 0, end = 0;
};
struct CellRows {
  uint32_t first = 0, end = 0;
  uint32_t count() const { return end - first; }
};
// A range of rows of tiles of frame_tile_size.
struct TileRows {
  uint32_t first = 0, end = 0;
};

struct IrradianceCells {
  uint32_t columns = 0, rows = 0;
  std::vector<CellPlace> places;
  std::vector<CellLight> lights;

  void fit(uint32_t width, uint32_t height) {
    columns = (width + cell_side - 1) / cell_side;
    rows = (height + cell_side - 1) / cell_side;
    places.resize(size());
    lights.resize(size());
  }
  size_t size() const { return size_t{columns} * rows; }
  // Returns the rows of cells that contain these rows of pixels, and `around` more on both sides.
  CellRows rows_of(PixelRows pixels, uint32_t around) const {
    const uint32_t first = pixels.first / cell_side, end = (pixels.end + cell_side - 1) / cell_side;
    return {first - std::min(first, around), std::min(end + around, rows)};
  }
};

}  // namespace sideray::rt
