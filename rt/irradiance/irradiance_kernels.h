// Does the arithmetic of the irradiance filter over sixteen cells at once, compiled for several instruction sets as
// rt/surfaces/shade_kernels.h is: plain arrays in, plain arrays out, same bits for each. Any thread may call it.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr int32_t cells_at_once = 16;
inline constexpr int32_t wall_steps = 4;                       // walls are looked for between cells 1, 2, 4 and 8 apart
inline constexpr int32_t cell_border = 1 << (wall_steps - 1);  // the longest of these steps
// Of the eight ways to a neighbour the forward ones; the others are those of the other cell.
inline constexpr int32_t wall_ways = 4;
inline constexpr int32_t wall_way_x[wall_ways] = {1, -1, 0, 1}, wall_way_y[wall_ways] = {0, 1, 1, 1};

// Refers to the data of a picture's cells, one array a component, with a border of cells that show nothing. Values of a whole
// block of sixteen may be read and written from any cell on.
struct CellColumns {
  float *position[3], *normal[3];
  float* width;                      // of a pixel there, world units; 0: nothing is drawn
  float* samples;                    // how many the light is the mean of
  float* most_near;                  // 1 / distance of the nearest that paths from cells around have met
  float *nearness, *open;            // as in CellLight
  float *next_nearness, *next_open;  // what a pass makes of them
  float *light[3], *next_light[3];   // likewise
  int32_t* walls;  // bit wall_ways * number + way: whether something stands in that way between cells 1 << number apart
  int32_t stride;  // cells from one row to the next
};

// Refers to sixteen pixels, one of each of the cells, by where they lie.
struct PixelColumns {
  float* position[3];
  float* depth;     // 0: nothing is drawn
  float* light[3];  // what they are given
};

// All functions take the sixteen cells from `at` on.
struct IrradianceKernels {
  // A pass of the filter over nearness and open, and over light, by cells 1 << number apart.
  void (*smooth)(const CellColumns& columns, int32_t at, int32_t number);
  void (*pass)(const CellColumns& columns, int32_t at, int32_t number);
  // Finds between which cells 1 << number apart a wall may stand that matters: bit i of `ways` stands for cell at + i. With
  // `by_distance` these are no farther apart than light is shared.
  void (*ask_for_walls)(const CellColumns& columns, int32_t at, int32_t number, bool by_distance, uint32_t (&ways)[wall_ways]);
  // Gives pixels the light of the cells around that show their plane: those of column and row `x`, `y` of their cells of 2x2.
  // Nothing stands between a pixel and a cell where nothing does from the pixel to its own cell and from there on.
  // Returns a bit for each that has got it; the others need rays, or cells that are farther off.
  uint32_t (*spread)(const CellColumns& columns, int32_t at, int32_t x, int32_t y, const PixelColumns& pixels);
};

// Returns the kernels for an instruction set: "avx512", "avx2", otherwise the baseline; null: the widest of the processor,
// which must have what it is asked for.
const IrradianceKernels& irradiance_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
