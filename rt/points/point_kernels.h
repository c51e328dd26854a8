// Does the arithmetic of points of opaque pixels, and of the rays that start there, over vectors of pixels; compiled
// for several instruction sets as rt/surfaces/shade_kernels.h is: plain arrays in, plain arrays out, same bits for
// each, and those of rt/masks/depth_points.cpp and rt/masks/mask_rays.cpp, which do it one by one. Any thread may call
// it.
#pragma once

#include <stdint.h>

#include "rt/points/point_tile.h"

namespace sideray::rt {

// Pixels around a tile that its points depend on, and values from one row to the next.
inline constexpr int seen_border = 2, seen_rows = point_tile_size + 2 * seen_border, seen_stride = 40;

// Holds a perspective view as ViewRays does, and a depth buffer's rounding.
struct PointView {
  double pixel_x, pixel_y;  // a pixel's size in normalized device coordinates
  double center[3], along_x[3], along_y[3];
  float eye[3];                       // where rays start
  double sign, w_x, w_y, w_z, w_one;  // of w, linear in normalized device coordinates
  double half_steps;                  // by which a depth may be off
  double noise;                       // share of that by which neighbours differ
  double step;                        // between stored depths; 0 = a float's own
  double subpixel;
  int32_t reversed, zero_to_one;
};

// Holds what the depth buffer shows at the pixels of a tile and around it. Columns and rows begin seen_border before
// the tile's.
struct SeenPixels {
  alignas(64) double distance[seen_rows * seen_stride];  // along the view ray; infinite = nothing
  double inverse[seen_rows * seen_stride];               // of the distance
  double w[seen_rows * seen_stride], off[seen_rows * seen_stride];
  double drawn[3][seen_rows * seen_stride];     // position by the depth buffer
  double position[3][seen_rows * seen_stride];  // with the rest pose's offset where that counts
  int64_t resting[seen_rows * seen_stride];     // all bits where that counts, else none
  float direction[3][seen_rows * seen_stride];  // of the view ray
  bool rests;                                   // some pixel does; where none does, position and resting are not set
};

enum RayKind : int32_t {
  rays_to_directional,
  rays_to_point,
  rays_to_spot,
  rays_to_sky,    // drawn in proportion to the cosine
  rays_to_drawn,  // to the sky, in directions that are drawn already: RaySamples::drawn
};

// Holds what rays are made to: a light, or the sky above the surface.
struct RayLight {
  RayKind kind;
  bool samples;        // its area; otherwise its middle
  float position[3];   // directional: the way to the light
  float direction[3];  // of a spot
  float frame[3][3];   // directional: about the way to the light, column by column
  float aperture;      // directional
  float radius, range, cos_outer;
  float t_far;         // directional, sky
  uint32_t count, index;  // rays that a pixel has of this kind, and which this is
};

// Holds the keys of the point sets of a tile's four by four blocks of 8x8 pixels.
struct SampleKeys {
  uint32_t order[16], x[16], y[16];
};

// Holds what a pixel's sample is, and whether the light sends anything to the pixel at all.
struct RaySamples {
  alignas(64) float u[point_tile_pixels], azimuth[point_tile_pixels];
  float sine[point_tile_pixels], cosine[point_tile_pixels];  // of the azimuth
  float drawn[3][point_tile_pixels];                         // directions of rays_to_drawn
  uint16_t wanted[tile_blocks];
};

enum InexactKind : int32_t { starts_as_others, starts_further, skips_near_hits };

// Says how rays of pixels that take the inexact test start.
struct InexactStart {
  InexactKind kind;
  uint32_t key;  // of their random numbers, without the pixel
};

// Refers to rays by component. The arrays have room for a tile's pixels and 16 more, which may be written.
struct RayArrays {
  float *origin[3], *direction[3], *t_near, *t_far;
  uint16_t* pixel;  // index in the tile
};

struct PointKernels {
  // Fills a row of `seen`, except positions and resting. `depth`: window depth of seen_stride pixels, negative =
  // nothing; `x`: of the first of them in the picture.
  void (*see)(const PointView& view, const double* depth, double x, double y, int row, SeenPixels& seen);
  // Fills a row of the tile's points, `row` of `seen`, from what is seen there and in two rows on both sides; adds to
  // `drawn`.
  void (*points)(const PointView& view, const SeenPixels& seen, int row, PointTile& tile);
  // Fills `wanted` and, where the light's area is sampled, u and the azimuth.
  void (*samples)(const RayLight& light, const SampleKeys& keys, const PointTile& tile, RaySamples& samples);
  // Makes the rays of the wanted pixels to the light; returns how many.
  uint32_t (*rays)(const RayLight& light, const InexactStart& start, const RaySamples& samples, const PointTile& tile,
                   const RayArrays& rays);
};

// Returns the kernels for an instruction set: "avx512", "avx2", otherwise the baseline; null: the widest of the processor,
// which must have what it is asked for.
const PointKernels& point_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
