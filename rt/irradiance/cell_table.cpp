#include "rt/irradiance/cell_table.h"

#include <algorithm>
#include <utility>

namespace sideray::rt {

void CellTable::fit(const IrradianceCells& cells) {
  if (width_ == cells.columns && height_ == cells.rows) return;
  width_ = cells.columns, height_ = cells.rows;
  // Rows end with padding, which blocks read beyond the last cell.
  const uint32_t blocks = (width_ + cells_at_once - 1) / cells_at_once;
  columns_.stride = cell_border + static_cast<int32_t>(blocks) * cells_at_once + cell_border;
  count_ = static_cast<size_t>(columns_.stride) * (height_ + 2 * size_t{cell_border}) + cells_at_once;
  values_.assign(float_columns * count_, 0.0f);
  walls_.assign(count_, 0);
  columns_.walls = walls_.data();
  float* next = values_.data();
  CellColumns& c = columns_;
  for (float** column : {&c.position[0], &c.position[1], &c.position[2], &c.normal[0], &c.normal[1], &c.normal[2], &c.width,
                         &c.samples, &c.most_near, &c.nearness, &c.open, &c.next_nearness, &c.next_open, &c.light[0],
                         &c.light[1], &c.light[2], &c.next_light[0], &c.next_light[1], &c.next_light[2]}) {
    *column = next;
    next += count_;
  }
}

void CellTable::fill(const IrradianceCells& cells, CellRows rows, Executor& executor) {
  fit(cells);
  const CellColumns& c = columns_;
  executor.run(rows.count(), [&](size_t index, uint32_t) {
    const size_t y = rows.first + index;
    const CellPlace* places = &cells.places[y * width_];
    const CellLight* lights = &cells.lights[y * width_];
    const int32_t first = row(y);
    std::fill_n(c.walls + first, width_, 0);
    for (int32_t x = 0; x < static_cast<int32_t>(width_); ++x) {
      const CellPlace& place = places[x];
      const int32_t at = first + x;
      for (int k = 0; k < 3; ++k) c.position[k][at] = place.position[k], c.normal[k][at] = place.normal[k];
      c.width[at] = place.width;
      c.samples[at] = lights[x].samples;
      c.nearness[at] = lights[x].nearness;
      c.open[at] = lights[x].open;
    }
  });
}

void CellTable::swap_smooth() {
  std::swap(columns_.nearness, columns_.next_nearness);
  std::swap(columns_.open, columns_.next_open);
}

void CellTable::swap_light() {
  for (int k = 0; k < 3; ++k) std::swap(columns_.light[k], columns_.next_light[k]);
}

glm::vec3 CellTable::light(size_t number) const {
  const int32_t at = place_of(number);
  return {columns_.light[0][at], columns_.light[1][at], columns_.light[2][at]};
}

bool CellTable::is_wall_between(size_t number, size_t neighbour) const {
  const int32_t from = place_of(std::min(number, neighbour)), to = place_of(std::max(number, neighbour));
  for (int32_t way = 0; way < wall_ways; ++way)
    if (from + wall_way_x[way] + wall_way_y[way] * columns_.stride == to) return (columns_.walls[from] >> way & 1) != 0;
  return false;
}

}  // namespace sideray::rt
