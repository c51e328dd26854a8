// Does the arithmetic of the shadow denoiser over rows of sixteen pixels, compiled for several instruction sets as
// rt/surfaces/shade_kernels.h is: plain arrays in, plain arrays out, same bits for each. Any thread may call it.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr int shadow_tile = 16;

// Holds a light and a view as shading::SfLight and shading::SfView do.
struct ShadowTerms {
  float light_position[3], light_radius, light_tan_radius, light_most_penumbra, light_most_frames;
  float origin_x, origin_y, step_x, step_y, before[3], before_offset;
};

// Refers to images of one layout, with a border of a tile all around where there is no surface.
struct ShadowPlanes {
  float *visibility, *filtered, *nearness, *reach;
  float *inverse, *slope_x, *slope_y;  // the same for all lights
  int32_t stride;                      // floats from one row to the next
};

// Refers to what a frame leaves to the next one.
struct ShadowHistoryPlanes {
  float *value, *frames, *inverse;
};

// Holds values of a tile, column by column.
struct alignas(64) ShadowColumns {
  float least[shadow_tile], most[shadow_tile];  // least and most visibility
  float distances[shadow_tile], hits[shadow_tile];
};

// All functions take the sixteen pixels from (x, y) on, which lie at index `at`.
struct ShadowKernels {
  void (*invert)(const float* depth, float* inverse);
  // Needs the inverse depths of the rows around.
  void (*slope)(const ShadowPlanes& planes, int32_t at);
  // `darkest`: the least visibility of the images that share a reach.
  void (*load)(const float* visibility, const float* darkest, const float* hit_distance, const ShadowPlanes& planes,
               int32_t at, ShadowColumns& columns);
  // `nearness`: that of the occluders of the tiles around, for pixels without an occluder among their neighbours.
  void (*prepare)(const ShadowTerms& terms, const ShadowPlanes& planes, int32_t at, int32_t x, int32_t y,
                  float nearness, float* most_reach);
  // `images`: several that share what is not their visibility.
  void (*blur)(const ShadowPlanes* images, int32_t count, int32_t at, int32_t step);
  // `motion`: sixteen x, sixteen y. `first`: index of pixel (0, 0).
  void (*accumulate)(const ShadowTerms& terms, const ShadowPlanes& planes, const ShadowHistoryPlanes& before,
                     const ShadowHistoryPlanes& after, const float* motion, int32_t first, int32_t x, int32_t y,
                     int32_t width, int32_t height);
};

// Returns the kernels for an instruction set: "avx512", "avx2", otherwise the baseline; null: the widest of the processor,
// which must have what it is asked for.
const ShadowKernels& shadow_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
