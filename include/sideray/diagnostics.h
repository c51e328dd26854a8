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

struct sideray_diagnostics {
  size_t size;
  /* Shadow, ambient occlusion and reflection rays of opaque pixels start where a ray through the pixel hits what it
   * shows, with that triangle's normal, instead of where the depth buffer has it. Pixels whose ray hits another
   * surface, or another pose of it, keep the depth. One more ray a pixel. */
  int32_t exact_points;
};

/* All off. */
SIDERAY_DEFAULTS(sideray_diagnostics, diagnostics)

#ifdef __cplusplus
}
#endif
#endif
