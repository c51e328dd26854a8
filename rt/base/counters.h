// What a trace counts and times. Plain values; each thread has its own, which are added up.
#pragma once

#include <cstdint>

namespace sideray::rt {

struct TraceCounters {
  uint64_t rays_primary = 0, rays_reflection = 0, rays_shadow = 0, rays_ao = 0;
  uint64_t pixels_total = 0, pixels_masked = 0;
  uint64_t layers_requested = 0, layers_found = 0, layers_shaded = 0, traversals_wasted = 0;
  uint64_t rays_skipped = 0, layers_skipped = 0;  // as in sideray_frame_stats, like the next
  uint64_t points_shaded = 0, points_not_finite = 0;
  uint64_t pixels_late = 0;        // masked ones that the deadline left without an answer
  uint64_t dropped_particles = 0;  // composite: sprites in view that rays do not meet
  double trace_ms = 0, denoise_ms = 0, shadow_ms = 0, ao_ms = 0;
  void operator+=(const TraceCounters& other);
};

}  // namespace sideray::rt
