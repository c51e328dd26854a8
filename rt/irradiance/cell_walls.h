// Finds walls between cells that show one plane, such as a wall on a floor: cells on its two sides share no light,
// however thin it is. Tests rays from cell to cell, but only where paths hit something nearer than the cells are to
// each other. Leaves and grates with cut-outs count as open, because their rays cost most. Keeps its memory between
// frames.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/base/executor.h"
#include "rt/base/ray.h"
#include "rt/embree/intersector.h"
#include "rt/irradiance/cell_table.h"
#include "rt/irradiance/irradiance_cells.h"

namespace sideray::rt {

// Returns the ray between two places, both raised along their normals so that it clears a curved surface.
Ray ray_between(const CellPlace& from, const CellPlace& to);

class CellWalls {
 public:
  // Takes the cells of a frame, and writes to the table how near occluders may be. The caller keeps both alive.
  void begin(const IrradianceCells& cells, const CellTable& table, Executor& executor);
  // Tests for walls between cells of these rows and those 1 << number beside or above them that may share light, and
  // writes them to the table. `by_distance`: only up to the distance at which light is shared.
  void look(int32_t number, bool by_distance, CellRows rows, const Intersector& intersector, Executor& executor);
  // Returns whether an occluder may be as near to a cell as the root of `squared`.
  bool is_near(size_t cell, float squared) const {
    const float share = margin * nearness_[cell];
    return squared * share * share > 1.0f;
  }

 private:
  static constexpr float margin = 2.0f;  // because few paths hit an occluder at its nearest point
  struct Scratch {
    std::vector<Ray> rays;
    std::vector<int32_t> cells, bits;
    std::vector<uint8_t> occluded;
  };
  void ask(size_t row, int32_t x, int32_t number, const uint32_t (&ways)[wall_ways], Scratch& scratch) const;
  void trace(const Intersector& intersector, Scratch& scratch);

  const IrradianceCells* cells_ = nullptr;
  const CellTable* table_ = nullptr;
  std::vector<float> nearness_, row_nearness_;  // 1 / distance of the nearest hit of paths from cells around
  std::vector<Scratch> scratch_;
};

}  // namespace sideray::rt
