/* Switches for comparison and measurement, not to draw with: the listings of Ray Tracing Gems II chapter 50 as they are
 * printed, and the exact answer to a shortcut that no frame can do without.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_DIAGNOSTICS_H
#define SIDERAY_DIAGNOSTICS_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A value of an enumeration that only this header names. */
#ifdef __cplusplus
#define SIDERAY_DIAGNOSTIC_VALUE(type, value) static_cast<type>(value)
#else
#define SIDERAY_DIAGNOSTIC_VALUE(type, value) ((type)(value))
#endif

/* Takes the first layer whose relative distance is below match_threshold (listing 50-2). */
#define SIDERAY_MATCH_DISTANCE SIDERAY_DIAGNOSTIC_VALUE(sideray_match, 2)
/* Starts one traversal a surface as listing 50-1 is printed: it loses surfaces. */
#define SIDERAY_STEP_LISTING SIDERAY_DIAGNOSTIC_VALUE(sideray_step, 2)
/* Moves the ray's origin by u * B: it loses the hit distance. */
#define SIDERAY_INEXACT_ORIGIN SIDERAY_DIAGNOSTIC_VALUE(sideray_inexact, 4)

/* What rays cost with nothing of the library around them, so that times of different machines and scenes can be held
 * against each other: coherent closest hits through the centre of every pixel, 16 rays at a time, in one high-quality
 * scene of all triangles, on the tracer's threads. docs/cli.md says more. */
typedef struct sideray_raw_frame {
  size_t size;
  /* In: with more triangles than this, instances share the scene of their mesh. That bounds the memory, which is up to
   * about 300 bytes a triangle and is given back. */
  uint64_t most_flat_triangles;
  double ms;          /* out: the best of five; 0 where nothing was measured */
  uint64_t triangles; /* out: in the scene */
  uint64_t is_flat;   /* out: 1 where no instances were left in it */
} sideray_raw_frame;

/* 2^22 triangles; the rest is 0. */
SIDERAY_DEFAULTS(sideray_raw_frame, raw_frame)

struct sideray_diagnostics {
  size_t size;
  /* Shadow, ambient occlusion and reflection rays of opaque pixels start where a ray through the pixel hits what it
   * shows, with that triangle's normal, instead of where the depth buffer has it. Pixels whose ray hits another
   * surface, or another pose of it, keep the depth. One more ray a pixel. */
  int32_t exact_points;
  /* Output: the library writes to it before the call that draws returns, and measures it after the timed frames. Needs
   * `repeats` and traced rays. NULL: not measured. */
  sideray_raw_frame* raw_frame;
  /* A budget without a clock: this many pieces of each kind of mask, of layers and of reflections are traced in a frame,
   * the same ones for any number of threads. 0 = none. */
  uint32_t budget_pieces;
};

/* All off. */
SIDERAY_DEFAULTS(sideray_diagnostics, diagnostics)

#ifdef __cplusplus
}
#endif
#endif
