// Does the arithmetic of the irradiance filter over sixteen cells at once. It is compiled for several instruction sets,
// as rt/surfaces/shade_kernels.h is: plain arrays in and out, the same bits for each set. Any thread may call it.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr int32_t cells_at_once = 16;
inline constexpr int32_t wall_steps = 4;                       // walls are searched between cells 1, 2, 4 and 8 apart
inline constexpr int32_t cell_border = 1 << (wall_steps - 1);  // the longest of these steps
// Four of the eight directions to neighbours; walls in the other four are stored with the neighbour.
inline constexpr int32_t wall_ways = 4;
inline constexpr int32_t wall_way_x[wall_ways] = {1, -1, 0, 1}, wall_way_y[wall_ways] = {0, 1, 1, 1};

// Refers to the data of a picture's cells, one array a component, with a border of cells without a surface. A whole
// block of sixteen may be read and written from any cell on.
struct CellColumns {
  float *position[3], *normal[3];
  float* width;                      // of a pixel's footprint there, world units; 0: no surface
  float* samples;                    // number of samples in `light`
  float* most_near;                  // 1 / distance of the nearest hit of paths from cells around
  float *nearness, *open;            // as in CellLight
  float *next_nearness, *next_open;  // results of a pass
  float *light[3], *next_light[3];   // red, green, blue; next_light: result of a pass
  int32_t* walls;  // bit wall_ways * number + way: something stands in that direction between cells 1 << number apart
  int32_t stride;  // cells from one row to the next
};

// Refers to sixteen pixels, one of each cell.
struct PixelColumns {
  float* position[3];
  float* depth;     // 0: no surface
  float* light[3];  // output
};

// All functions process the sixteen cells from `at` on.
struct IrradianceKernels {
  // Run a pass of the filter over cells 1 << number apart: smooth() over nearness and open, pass() over light.
  void (*smooth)(const CellColumns& columns, int32_t at, int32_t number);
  void (*pass)(const CellColumns& columns, int32_t at, int32_t number);
  // Finds cells 1 << number apart between which a relevant wall may stand: bit i of `ways` is for cell at + i. With
  // `by_distance` they are no farther apart than light is shared.
  void (*ask_for_walls)(const CellColumns& columns, int32_t at, int32_t number, bool by_distance, uint32_t (&ways)[wall_ways]);
  // Interpolates the light for pixels, those in column and row `x`, `y` of their cells of 2x2, from cells around that
  // show their plane. Nothing stands between a pixel and a cell if nothing does between the pixel and its own cell, and
  // between the two cells. Returns a bit for each pixel that is done; the others need rays, or more distant cells.
  uint32_t (*spread)(const CellColumns& columns, int32_t at, int32_t x, int32_t y, const PixelColumns& pixels);
};

// Returns the kernels of an instruction set: "avx512", "avx2", otherwise the baseline; null selects the processor's
// widest. The processor must have the set.
const IrradianceKernels& irradiance_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
