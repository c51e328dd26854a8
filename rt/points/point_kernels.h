// Computes the points of opaque pixels and the rays that start there, over vectors of pixels. It is compiled for
// several instruction sets, as rt/surfaces/shade_kernels.h is: plain arrays in and out, the same bits for each set and
// as in rt/masks/depth_points.cpp and rt/masks/mask_rays.cpp, which process single pixels. Any thread may call it.
#pragma once

#include <stdint.h>

#include "rt/points/point_tile.h"

namespace sideray::rt {

// Pixels around a tile that its points depend on; rows; row length in values.
inline constexpr int seen_border = 2, seen_rows = point_tile_size + 2 * seen_border, seen_stride = 40;

// Holds a perspective view, as ViewRays does, and the depth buffer's error.
struct PointView {
  double pixel_x, pixel_y;  // a pixel's size in normalized device coordinates
  double center[3], along_x[3], along_y[3];
  float eye[3];                       // where rays start
  double sign, w_x, w_y, w_z, w_one;  // of w, linear in normalized device coordinates
  double half_steps;                  // error of a depth, in half steps
  double noise;                       // share of that error by which neighbours differ
  double step;                        // between stored depths; 0 = a float's own
  double subpixel;
  int32_t reversed, zero_to_one;
};

// Holds the depth buffer's content at the pixels of a tile and around it. Columns and rows start seen_border before the
// tile's.
struct SeenPixels {
  alignas(64) double distance[seen_rows * seen_stride];  // along the view ray; infinite = no surface
  double inverse[seen_rows * seen_stride];               // of the distance
  double w[seen_rows * seen_stride], off[seen_rows * seen_stride];
  double drawn[3][seen_rows * seen_stride];     // position by the depth buffer
  double position[3][seen_rows * seen_stride];  // with the rest pose's offset, if there is one
  int64_t resting[seen_rows * seen_stride];     // all bits set if the pixel has a rest pose, else 0
  float direction[3][seen_rows * seen_stride];  // of the view ray
  bool rests;                                   // some pixel has a rest pose; if false, position and resting are unset
};

enum RayKind : int32_t {
  rays_to_directional,
  rays_to_point,
  rays_to_spot,
  rays_to_sky,    // sampled in proportion to the cosine
  rays_to_drawn,  // to the sky, in sampled directions: RaySamples::drawn
};

// Describes the target of rays: a light, or the sky above the surface.
struct RayLight {
  RayKind kind;
  bool samples;        // samples the light's area; false: aims at its centre
  float position[3];   // directional: direction to the light
  float direction[3];  // of a spot
  float frame[3][3];   // directional: frame around the direction to the light, column by column
  float aperture;      // directional
  float radius, range, cos_outer;
  float t_far;         // directional, sky
  uint32_t count, index;  // rays of this kind a pixel, and index of this one
};

// Holds the keys of point sets, one for each of the tile's 4x4 blocks of 8x8 pixels.
struct SampleKeys {
  uint32_t order[16], x[16], y[16];
};

// Holds the pixels' samples, and whether the light reaches each pixel at all.
struct RaySamples {
  alignas(64) float u[point_tile_pixels], azimuth[point_tile_pixels];
  float sine[point_tile_pixels], cosine[point_tile_pixels];  // of the azimuth
  float drawn[3][point_tile_pixels];                         // directions of rays_to_drawn
  uint16_t wanted[tile_blocks];
};

enum InexactKind : int32_t { starts_as_others, starts_further, skips_near_hits };

// Says how the rays of pixels with the inexact test start.
struct InexactStart {
  InexactKind kind;
  uint32_t key;  // of their random numbers, to be combined with the pixel
};

// Refers to rays by component. Arrays have room for a tile's pixels and 16 more, which may be overwritten.
struct RayArrays {
  float *origin[3], *direction[3], *t_near, *t_far;
  uint16_t* pixel;  // index in the tile
};

struct PointKernels {
  // Fills a row of `seen`, except position and resting. `depth`: window depth of seen_stride pixels, negative = no
  // surface; `x`: column of the first of them in the picture.
  void (*see)(const PointView& view, const double* depth, double x, double y, int row, SeenPixels& seen);
  // Fills a row of the tile's points from `row` of `seen` and the two rows on each side; sets their bits in `drawn`.
  void (*points)(const PointView& view, const SeenPixels& seen, int row, PointTile& tile);
  // Fills `wanted` and, if the light's area is sampled, u and azimuth.
  void (*samples)(const RayLight& light, const SampleKeys& keys, const PointTile& tile, RaySamples& samples);
  // Makes the rays of the wanted pixels to the light; returns their number.
  uint32_t (*rays)(const RayLight& light, const InexactStart& start, const RaySamples& samples, const PointTile& tile,
                   const RayArrays& rays);
};

// Returns the kernels of an instruction set: "avx512", "avx2", otherwise the baseline; null selects the processor's
// widest. The processor must have the set.
const PointKernels& point_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
