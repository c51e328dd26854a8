// Does the arithmetic of the layers' denoiser over sixteen layers at once, compiled for several instruction sets as
// rt/surfaces/shade_kernels.h is: plain arrays in, plain arrays out, same bits for each. Any thread may call it.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr int32_t layers_at_once = 16;
inline constexpr int32_t layer_filter_passes = 4;
inline constexpr int32_t layer_filter_border = 1 << (layer_filter_passes - 1);  // the longest step in pixels
inline constexpr int32_t kept_steps = 2;  // passes whose neighbours are needed twice
// The filter's radius is this share of the lobe's: what is reflected gets wider by sqrt(1 + share^2), 12 %.
inline constexpr float share_of_lobe = 0.5f;

// Refers to the data of layers, one array a component. Sixteen values before each array and behind it may be read;
// those of the last sixteen that are no layers may be written.
struct LayerColumns {
  float *position[3], *normal[3], *geometric_normal[3];
  float* roughness;              // perceptual
  float *width, *spread;         // of the pixel there, world units; and per unit of distance
  float* nearness;               // of what is reflected
  float* lobe;                   // the lobe's radius at distance 1, by the filter's share
  float* reach;                  // world units over which neighbours reflect alike; negative: not filtered
  float* reflected[4];           // radiance; w: 1 where a surface was hit, 0 where the environment was
  float* filtered[4];            // what a pass makes of it
  int32_t* surface;              // id; its complement for what is seen through it
  int32_t* next;                 // next layer of the same pixel; negative = none
  int32_t* pixel;                // index in `first`
  int32_t* near[kept_steps][8];  // the layers of the eight pixels around at distances 1 and 2; negative = none
  int32_t* first;                // first layer of every pixel, with a border of layer_filter_border; negative = none
  int32_t stride;                // pixels from one row of `first` to the next
};

// All functions take the sixteen layers from `at` on.
struct LayerFilterKernels {
  // Finds the neighbours of the first passes, and decides from what is reflected around how far to filter. Also limits
  // what a single direction brings to what is shown: `filtered` is what the first pass takes.
  void (*prepare)(const LayerColumns& columns, int32_t at);
  // Runs a pass: `filtered` from `reflected`.
  void (*blur)(const LayerColumns& columns, int32_t at, int32_t pass);
};

// Returns the kernels for an instruction set: "avx512", "avx2", otherwise the baseline; null: the widest of the processor,
// which must have what it is asked for.
const LayerFilterKernels& layer_filter_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
