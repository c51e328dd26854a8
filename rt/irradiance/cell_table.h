// Holds a picture's cells as the filter's kernels take them: a column for each value, with a border. Keeps its memory from frame
// to frame. Different cells may be written at the same time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/executor.h"
#include "rt/irradiance/irradiance_cells.h"
#include "rt/irradiance/irradiance_kernels.h"

namespace sideray::rt {

class CellTable {
 public:
  // Takes rows of the cells of a frame: their light as it was sampled, no walls.
  void fill(const IrradianceCells& cells, CellRows rows, Executor& executor);
  // What passes wrote becomes what the next ones read.
  void swap_smooth();
  void swap_light();

  const CellColumns& columns() const { return columns_; }
  uint32_t width() const { return width_; }  // in cells
  uint32_t height() const { return height_; }
  // Returns where a row begins in the columns, and where cell `number` of IrradianceCells is.
  int32_t row(size_t y) const { return columns_.stride * (cell_border + static_cast<int32_t>(y)) + cell_border; }
  int32_t place_of(size_t number) const { return row(number / width_) + static_cast<int32_t>(number % width_); }
  glm::vec3 light(size_t number) const;
  // Returns whether something stands between neighbours.
  bool is_wall_between(size_t number, size_t neighbour) const;

 private:
  static constexpr size_t float_columns = 19;
  void fit(const IrradianceCells& cells);

  uint32_t width_ = 0, height_ = 0;
  size_t count_ = 0;  // of a column's values
  std::vector<float> values_;
  std::vector<int32_t> walls_;
  CellColumns columns_{};
};

}  // namespace sideray::rt
