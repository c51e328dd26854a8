// Does the arithmetic of the layers' denoiser over sixteen layers at once. It is compiled for several instruction sets,
// as rt/surfaces/shade_kernels.h is: plain arrays in and out, the same bits for each set. Any thread may call it.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr int32_t layers_at_once = 16;
inline constexpr int32_t layer_filter_passes = 4;
inline constexpr int32_t layer_filter_border = 1 << (layer_filter_passes - 1);  // the longest step in pixels
inline constexpr int32_t kept_steps = 2;  // passes whose neighbours are needed twice
// The filter's radius as a share of the lobe's: reflections get wider by sqrt(1 + share^2), which is 12 %.
inline constexpr float share_of_lobe = 0.5f;

// Refers to the data of layers, one array a component. Sixteen values before and behind each array may be read; values
// behind the last layer, up to a multiple of sixteen, may be written.
struct LayerColumns {
  float *position[3], *normal[3], *geometric_normal[3];
  float* roughness;              // perceptual
  float *width, *spread;         // of the pixel's footprint there, in world units; and per unit of distance
  float* nearness;               // of the reflected surface
  float* lobe;                   // radius at distance 1, times share_of_lobe
  float* reach;                  // filter radius in world units; negative: not filtered
  float* reflected[4];           // radiance; w: 1 if a surface was hit, 0 for the environment
  float* filtered[4];            // result of a pass
  int32_t* surface;              // surface id; its complement for light seen through the surface
  int32_t* next;                 // next layer of the same pixel; negative = none
  int32_t* pixel;                // index in `first`
  int32_t* near[kept_steps][8];  // layers of the eight pixels around at distances 1 and 2; negative = none
  int32_t* first;                // first layer of every pixel, with a border of layer_filter_border; negative = none
  int32_t stride;                // row length of `first` in pixels
};

// All functions process the sixteen layers from `at` on.
struct LayerFilterKernels {
  // Finds the neighbours of the first passes, and sets `reach` by the distance of the reflections around. Also clamps
  // outliers: `filtered` is the input of the first pass.
  void (*prepare)(const LayerColumns& columns, int32_t at);
  // Runs a pass, from `reflected` to `filtered`.
  void (*blur)(const LayerColumns& columns, int32_t at, int32_t pass);
};

// Returns the kernels of an instruction set: "avx512", "avx2", otherwise the baseline; null selects the processor's
// widest. The processor must have the set.
const LayerFilterKernels& layer_filter_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
