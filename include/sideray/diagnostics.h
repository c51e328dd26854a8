/* Switches for comparison and measurement, not for drawing: the listings of Ray Tracing Gems II chapter 50 as printed,
 * and the exact alternative to a shortcut that every frame takes.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_DIAGNOSTICS_H
#define SIDERAY_DIAGNOSTICS_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A value of an enumeration that is declared only in this header. */
#ifdef __cplusplus
#define SIDERAY_DIAGNOSTIC_VALUE(type, value) static_cast<type>(value)
#else
#define SIDERAY_DIAGNOSTIC_VALUE(type, value) ((type)(value))
#endif

/* Uses the first layer whose relative difference in distance is below match_threshold (listing 50-2). */
#define SIDERAY_MATCH_DISTANCE SIDERAY_DIAGNOSTIC_VALUE(sideray_match, 2)
/* Starts one traversal a surface as listing 50-1 prints it, which loses surfaces. */
#define SIDERAY_STEP_LISTING SIDERAY_DIAGNOSTIC_VALUE(sideray_step, 2)
/* Moves the ray's origin by u * B, which loses the hit distance. */
#define SIDERAY_INEXACT_ORIGIN SIDERAY_DIAGNOSTIC_VALUE(sideray_inexact, 4)

/* What rays cost without the library's own code, so that times of different machines and scenes can be compared:
 * coherent closest hits through the centre of every pixel, 16 rays at a time, in one high-quality scene of all
 * triangles, on the tracer's threads. docs/cli.md says more. */
typedef struct sideray_raw_frame {
  size_t size;
  /* In: with more triangles than this, instances share the scene of their mesh. That bounds the temporary memory, which
   * is up to about 300 bytes a triangle. */
  uint64_t most_flat_triangles;
  double ms;          /* out: the best of five; 0 = not measured */
  uint64_t triangles; /* out: in the scene */
  uint64_t is_flat;   /* out: 1 if the scene contains no instances */
} sideray_raw_frame;

/* 2^22 triangles; the rest is 0. */
SIDERAY_DEFAULTS(sideray_raw_frame, raw_frame)

struct sideray_diagnostics {
  size_t size;
  /* Rays for shadows, ambient occlusion and reflections of opaque pixels start at the hit of a ray through the pixel,
   * with that triangle's normal, not at the depth buffer's position. A pixel whose ray hits another surface, or another
   * pose of its surface, uses the depth. Costs one more ray a pixel. */
  int32_t exact_points;
  /* Output: the library writes it before the drawing call returns, and measures it after the timed frames. Needs
   * `repeats` and traced rays. NULL: not measured. */
  sideray_raw_frame* raw_frame;
  /* A budget without a clock: each frame traces this many pieces of each kind of mask, of layers and of reflections,
   * the same ones for any number of threads. 0 = none. */
  uint32_t budget_pieces;
};

/* All off. */
SIDERAY_DEFAULTS(sideray_diagnostics, diagnostics)

#ifdef __cplusplus
}
#endif
#endif
