// Does the arithmetic of the shadow denoiser over rows of sixteen pixels. It is compiled for several instruction sets,
// as rt/surfaces/shade_kernels.h is: plain arrays in and out, the same bits for each set. Any thread may call it.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr int shadow_tile = 16;

// Holds the fields of shading::SfLight and shading::SfView.
struct ShadowTerms {
  float light_position[3], light_radius, light_tan_radius, light_most_penumbra, light_most_frames;
  float origin_x, origin_y, step_x, step_y, before[3], before_offset;
};

// Refers to images of one layout, all with a border of one tile that has no surface.
struct ShadowPlanes {
  float *visibility, *filtered, *nearness, *reach;
  float *inverse, *slope_x, *slope_y;  // shared by all lights
  int32_t origin;                      // index of pixel (0, 0)
  int32_t stride;                      // floats from one row to the next
};

// Refers to the images that a frame passes on to the next.
struct ShadowHistoryPlanes {
  float *value, *frames, *inverse;
};

// Refers to what is averaged with the previous frames.
struct ShadowSequence {
  ShadowTerms terms;
  ShadowPlanes planes;
  ShadowHistoryPlanes before, after;
  int32_t width, height;
};

// Holds a tile's values, one entry a column.
struct alignas(64) ShadowColumns {
  float least[shadow_tile], most[shadow_tile];  // smallest and largest visibility
  float distances[shadow_tile], hits[shadow_tile];
};

// Says how far occluders of a tile are, and how far its pixels are blurred.
struct alignas(64) ShadowTileReach {
  float longest[shadow_tile];  // one entry a column
  float nearness;              // of the occluders in the tiles around, for pixels without an occluder nearby
};

// All functions process the sixteen pixels from (x, y) on; the first is at index `at`.
struct ShadowKernels {
  void (*invert)(const float* depth, float* inverse);
  // Needs the inverse depths of the rows above and below.
  void (*slope)(const ShadowPlanes& planes, int32_t at);
  // `darkest`: the least visibility of the images that share a reach.
  void (*load)(const float* visibility, const float* darkest, const float* hit_distance, const ShadowPlanes& planes,
               int32_t at, ShadowColumns& columns);
  void (*prepare)(const ShadowTerms& terms, const ShadowPlanes& planes, int32_t x, int32_t y, ShadowTileReach& reach);
  // `images`: several that share all planes except visibility and filtered.
  void (*blur)(const ShadowPlanes* images, int32_t count, int32_t at, int32_t step);
  // `motion`: sixteen x, then sixteen y.
  void (*accumulate)(const ShadowSequence& sequence, const float* motion, int32_t x, int32_t y);
};

// Returns the kernels of an instruction set: "avx512", "avx2", otherwise the baseline; null selects the processor's
// widest. The processor must have the set.
const ShadowKernels& shadow_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
