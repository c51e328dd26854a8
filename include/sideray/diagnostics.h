/* Switches of the offscreen tier that take a shortcut away which no frame can do without: to measure what it costs, not
 * to draw with. Conventions are those of sideray.h. */
#ifndef SIDERAY_DIAGNOSTICS_H
#define SIDERAY_DIAGNOSTICS_H

#include <sideray/sideray.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Of the pictures drawn from now on: shadow, ambient occlusion and reflection rays of opaque pixels start where a ray
 * through the pixel meets what it shows, with that triangle's normal, instead of where the depth buffer has it. Pixels
 * whose ray meets another surface, or another pose of it, keep the depth. One more ray a pixel. */
SIDERAY_API sideray_status sideray_renderer_set_exact_points(sideray_renderer* renderer, int32_t exact,
                                                             sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
