// Counts and times the work of a tracing thread, a job, a frame or a picture; each is the sum of its parts. Plain
// values; any thread.
#pragma once

#include <algorithm>
#include <cstdint>

namespace sideray::rt {

// Lists all counters. Those that sideray_frame_stats has and explains are copied by name: a new one takes a line here
// and a field there. Times and counts are summed over positions; of memory (HELD) the maximum counts.
#define SIDERAY_COUNTERS(TIME, COUNT, HELD)                                       \
  TIME(readback_ms)                                                               \
  TIME(trace_ms)                                                                  \
  TIME(denoise_ms)                                                                \
  TIME(upload_ms)                                                                 \
  TIME(trace_shadow_ms)                                                           \
  TIME(trace_ao_ms)                                                               \
  COUNT(rays_primary)                                                             \
  COUNT(rays_reflection)                                                          \
  COUNT(rays_shadow)                                                              \
  COUNT(rays_ao)                                                                  \
  COUNT(rays_bounce)                                                              \
  COUNT(pixels_total)                                                             \
  COUNT(pixels_masked)                                                            \
  COUNT(layers_requested)                                                         \
  COUNT(layers_found)                                                             \
  COUNT(traversals_wasted)                                                        \
  COUNT(pixels_late)                                                              \
  COUNT(pixels_older)                                                             \
  COUNT(mask_pixels_late)                                                         \
  COUNT(mask_pixels_older)                                                        \
  COUNT(mask_pixels_checked)                                                      \
  COUNT(mask_pixels_astray)                                                       \
  COUNT(reflection_pixels_late)                                                   \
  COUNT(reflection_pixels_older)                                                  \
  COUNT(irradiance_pixels_late)                                                   \
  COUNT(irradiance_pixels_older)                                                  \
  COUNT(jobs_starved)                                                             \
  HELD(answer_age)                                                                \
  HELD(frames_waiting)                                                            \
  COUNT(dropped_particles)                                                        \
  COUNT(layers_borrowed)                                                          \
  COUNT(layers_refracted)                                                         \
  COUNT(bytes_readback)                                                           \
  COUNT(bytes_upload)                                                             \
  COUNT(points_shaded)                                                            \
  COUNT(points_not_finite)                                                        \
  HELD(bytes_cache)

struct Counters {
#define SIDERAY_TIME(name) double name = 0;
#define SIDERAY_COUNT(name) uint64_t name = 0;
  SIDERAY_COUNTERS(SIDERAY_TIME, SIDERAY_COUNT, SIDERAY_COUNT)
#undef SIDERAY_TIME
#undef SIDERAY_COUNT

  void operator+=(const Counters& part) {
#define SIDERAY_ADD(name) name += part.name;
#define SIDERAY_HOLD(name) name = std::max(name, part.name);
    SIDERAY_COUNTERS(SIDERAY_ADD, SIDERAY_ADD, SIDERAY_HOLD)
#undef SIDERAY_ADD
#undef SIDERAY_HOLD
  }
};

}  // namespace sideray::rt
