#include "rt/irradiance/cell_walls.h"

#include <algorithm>
#include <cstdlib>

namespace sideray::rt {
namespace {

// Of the way, by which its ends are raised: a surface that turns by 37 degrees over it, the most that cells of one plane do,
// bulges by a third of that.
constexpr float raised = 0.25f;
constexpr float short_of_end = 1.0f - 0x1p-6f;
constexpr int around = 3;  // cells on each side whose paths tell of what is near

}  // namespace

Ray ray_between(const CellPlace& from, const CellPlace& to) {
  const float lift = raised * glm::distance(from.position, to.position);
  const glm::vec3 start = from.position + lift * from.normal;
  return {start, 0.0f, to.position + lift * to.normal - start, short_of_end};
}

void CellWalls::begin(const IrradianceCells& cells, Executor& executor) {
  cells_ = &cells;
  scratch_.resize(executor.threads());
  walls_.assign(cells.size(), 0);
  nearness_.resize(cells.size()), row_nearness_.resize(cells.size());
  const int columns = static_cast<int>(cells.columns), rows = static_cast<int>(cells.rows);
  executor.run(cells.rows, [&](size_t row, uint32_t) {
    const CellLight* lights = &cells.lights[row * cells.columns];
    for (int x = 0; x < columns; ++x) {
      float most = 0.0f;
      for (int u = std::max(x - around, 0); u <= std::min(x + around, columns - 1); ++u) most = std::max(most, lights[u].most_near);
      row_nearness_[row * cells.columns + static_cast<size_t>(x)] = most;
    }
  });
  executor.run(cells.rows, [&](size_t row, uint32_t) {
    const int y = static_cast<int>(row);
    float* most = &nearness_[row * cells.columns];
    std::fill_n(most, columns, 0.0f);
    for (int v = std::max(y - around, 0); v <= std::min(y + around, rows - 1); ++v) {
      const float* of_row = &row_nearness_[static_cast<size_t>(v) * cells.columns];
      for (int x = 0; x < columns; ++x) most[x] = std::max(most[x], of_row[x]);
    }
  });
}

void CellWalls::trace(const Intersector& intersector, Scratch& scratch) {
  if (scratch.rays.empty()) return;
  scratch.occluded.resize(scratch.rays.size());
  intersector.occluded(scratch.rays, false, scratch.occluded.data(), OpaqueSet::visible_in_reflection);
  for (size_t i = 0; i < scratch.rays.size(); ++i)
    if (scratch.occluded[i]) walls_[scratch.cells[i]] |= scratch.bits[i];
}

bool CellWalls::stands(size_t cell, int i, int j, size_t number) const {
  const bool forward = j > 0 || (j == 0 && i > 0);
  const glm::ivec2 to = forward ? glm::ivec2(i, j) : glm::ivec2(-i, -j);
  const auto way = static_cast<size_t>(to.y == 0 ? 0 : to.x + 2);
  const int step = static_cast<int>(steps[number]);
  return (walls_[forward ? cell : at(cell, i * step, j * step)] & bit(number, way)) != 0;
}

}  // namespace sideray::rt
