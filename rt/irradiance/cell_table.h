// Holds a picture's cells for the filter's kernels: one column a value, with a border. It reuses its memory every
// frame. Different cells may be written at the same time.
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
  // Copies rows of a frame's cells: their sampled light, without walls.
  void fill(const IrradianceCells& cells, CellRows rows, Executor& executor);
  // Swap the results of a pass with its inputs, for the next pass.
  void swap_smooth();
  void swap_light();

  const CellColumns& columns() const { return columns_; }
  uint32_t width() const { return width_; }  // in cells
  uint32_t height() const { return height_; }
  // Return the index in the columns of a row's start, and of cell `number` of IrradianceCells.
  int32_t row(size_t y) const { return columns_.stride * (cell_border + static_cast<int32_t>(y)) + cell_border; }
  int32_t place_of(size_t number) const { return row(number / width_) + static_cast<int32_t>(number % width_); }
  glm::vec3 light(size_t number) const;
  // Returns whether something stands between two neighbours.
  bool is_wall_between(size_t number, size_t neighbour) const;

 private:
  static constexpr size_t float_columns = 19;
  void fit(const IrradianceCells& cells);

  uint32_t width_ = 0, height_ = 0;
  size_t count_ = 0;  // values in a column
  std::vector<float> values_;
  std::vector<int32_t> walls_;
  CellColumns columns_{};
};

}  // namespace sideray::rt
