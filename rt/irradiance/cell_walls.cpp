#include "rt/irradiance/cell_walls.h"

#include <algorithm>
#include <bit>

namespace sideray::rt {
namespace {

// Height of the ray's ends as a share of its length. Cells of one plane differ by at most 37 degrees, and such a
// surface bulges by a third of that height.
constexpr float raised = 0.25f;
constexpr float short_of_end = 1.0f - 0x1p-6f;
// Cells on each side whose paths are taken into account: with 3, one pixel in 150,000 beside a wall of 1 cm leaks in a
// first frame, because no path hits the wall where it is near.
constexpr int around = 5;

}  // namespace

Ray ray_between(const CellPlace& from, const CellPlace& to) {
  const float lift = raised * glm::distance(from.position, to.position);
  const glm::vec3 start = from.position + lift * from.normal;
  return {start, 0.0f, to.position + lift * to.normal - start, short_of_end};
}

void CellWalls::begin(const IrradianceCells& cells, const CellTable& table, Executor& executor) {
  cells_ = &cells;
  table_ = &table;
  scratch_.resize(executor.threads());
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
    std::copy_n(most, columns, table.columns().most_near + table.row(row));
  });
}

void CellWalls::look(int32_t number, bool by_distance, CellRows rows, const Intersector& intersector, Executor& executor) {
  const IrradianceKernels& kernels = irradiance_kernels(intersector.isa().c_str());
  executor.run(rows.count(), [&](size_t index, uint32_t worker) {
    const size_t row = rows.first + index;
    Scratch& scratch = scratch_[worker];
    scratch.rays.clear(), scratch.cells.clear(), scratch.bits.clear();
    for (int32_t x = 0; x < static_cast<int32_t>(cells_->columns); x += cells_at_once) {
      uint32_t ways[wall_ways];
      kernels.ask_for_walls(table_->columns(), table_->row(row) + x, number, by_distance, ways);
      ask(row, x, number, ways, scratch);
    }
    trace(intersector, scratch);
  });
}

// Adds the rays of the block of cells that starts at `x`.
void CellWalls::ask(size_t row, int32_t x, int32_t number, const uint32_t (&ways)[wall_ways], Scratch& scratch) const {
  const auto columns = static_cast<int64_t>(cells_->columns);
  for (uint32_t bits = ways[0] | ways[1] | ways[2] | ways[3]; bits != 0; bits &= bits - 1) {
    const int32_t lane = std::countr_zero(bits);
    const int64_t cell = static_cast<int64_t>(row) * columns + x + lane;
    for (int32_t way = 0; way < wall_ways; ++way) {
      if ((ways[way] >> lane & 1u) == 0) continue;
      const int64_t other = cell + (wall_way_x[way] + wall_way_y[way] * columns) * (int64_t{1} << number);
      scratch.rays.push_back(
          ray_between(cells_->places[static_cast<size_t>(cell)], cells_->places[static_cast<size_t>(other)]));
      scratch.cells.push_back(table_->row(row) + x + lane);
      scratch.bits.push_back(1 << (wall_ways * number + way));
    }
  }
}

void CellWalls::trace(const Intersector& intersector, Scratch& scratch) {
  if (scratch.rays.empty()) return;
  scratch.occluded.resize(scratch.rays.size());
  intersector.occluded(scratch.rays, false, scratch.occluded.data(), OpaqueSet::walls);
  for (size_t i = 0; i < scratch.rays.size(); ++i)
    if (scratch.occluded[i]) table_->columns().walls[scratch.cells[i]] |= scratch.bits[i];
}

}  // namespace sideray::rt
