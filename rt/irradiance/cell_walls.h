// Finds out where something stands between two cells that show one plane, such as a wall on a floor: its two sides share no
// light, however thin it is. Rays from cell to cell tell, and are sent only where paths have met something nearer than the
// cells are apart. Keeps its memory from frame to frame.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rt/base/executor.h"
#include "rt/base/ray.h"
#include "rt/embree/intersector.h"
#include "rt/irradiance/irradiance_cells.h"

namespace sideray::rt {

// Returns the ray from a place to another, both raised along their normals so that it clears a bent surface.
Ray ray_between(const CellPlace& from, const CellPlace& to);

class CellWalls {
 public:
  static constexpr std::array<uint32_t, 4> steps{1, 2, 4, 8};

  // Takes the cells of a frame. The caller keeps them.
  void begin(const IrradianceCells& cells, Executor& executor);
  // Looks between cells of these rows and those steps[number] beside or above them of which share(cell, other, the way to it)
  // says that they may share light.
  template <typename Share>
  void look(size_t number, CellRows rows, const Intersector& intersector, Executor& executor, const Share& share);

  // Returns whether something was found between a cell and the one i steps to its right and j steps up, each -1, 0 or 1.
  bool stands(size_t cell, int i, int j, size_t number) const;
  // Returns whether anything may stand as near to a cell as the root of `squared`.
  bool is_near(size_t cell, float squared) const {
    const float share = margin * nearness_[cell];
    return squared * share * share > 1.0f;
  }

 private:
  static constexpr float margin = 2.0f;  // few of the paths meet what is near where it is nearest
  // Of the eight ways to a neighbour the forward ones; the others are those of the other cell.
  static constexpr std::array<glm::ivec2, 4> ways{{{1, 0}, {-1, 1}, {0, 1}, {1, 1}}};
  struct Scratch {
    std::vector<Ray> rays;
    std::vector<uint32_t> cells;
    std::vector<uint16_t> bits;
    std::vector<uint8_t> occluded;
  };
  static uint16_t bit(size_t number, size_t way) { return static_cast<uint16_t>(1u << (4 * number + way)); }
  size_t at(size_t cell, int columns, int rows) const {
    return static_cast<size_t>(static_cast<int64_t>(cell) + columns + int64_t{rows} * cells_->columns);
  }
  void trace(const Intersector& intersector, Scratch& scratch);

  const IrradianceCells* cells_ = nullptr;
  std::vector<float> nearness_, row_nearness_;  // 1 / distance of the nearest that paths from cells around have met
  std::vector<uint16_t> walls_;
  std::vector<Scratch> scratch_;
};

template <typename Share>
void CellWalls::look(size_t number, CellRows rows, const Intersector& intersector, Executor& executor, const Share& share) {
  const int step = static_cast<int>(steps[number]), columns = static_cast<int>(cells_->columns);
  executor.run(rows.end - rows.first, [&](size_t index, uint32_t worker) {
    const size_t row = rows.first + index;
    Scratch& scratch = scratch_[worker];
    scratch.rays.clear(), scratch.cells.clear(), scratch.bits.clear();
    const int y = static_cast<int>(row);
    for (int x = 0; x < columns; ++x) {
      const size_t cell = row * cells_->columns + static_cast<size_t>(x);
      const CellPlace& place = cells_->places[cell];
      if (!(place.width > 0.0f)) continue;
      for (size_t way = 0; way < ways.size(); ++way) {
        const glm::ivec2 to = step * ways[way];
        if (x + to.x < 0 || x + to.x >= columns || y + to.y >= static_cast<int>(cells_->rows)) continue;
        const size_t other = at(cell, to.x, to.y);
        const CellPlace& there = cells_->places[other];
        if (!(there.width > 0.0f)) continue;
        const glm::vec3 apart = there.position - place.position;
        const float squared = glm::dot(apart, apart);
        if (!(is_near(cell, squared) || is_near(other, squared)) || !share(cell, other, apart)) continue;
        scratch.rays.push_back(ray_between(place, there));
        scratch.cells.push_back(static_cast<uint32_t>(cell));
        scratch.bits.push_back(bit(number, way));
      }
    }
    trace(intersector, scratch);
  });
}

}  // namespace sideray::rt
