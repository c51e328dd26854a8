#include "bridge/drawing/frame_counters.h"

namespace sideray::bridge {

void FrameCounters::operator+=(const FrameCounters& frame) {
  trace += frame.trace;
  fragments.matched += frame.fragments.matched;
  fragments.missed += frame.fragments.missed;
  fragments.misassigned += frame.fragments.misassigned;
  duplicated += frame.duplicated;
}

void state_counters(const FrameCounters& counters, sideray_render_stats& stats) {
  const rt::Counters& t = counters.trace;
  stats.rays_primary = t.rays_primary;
  stats.rays_reflection = t.rays_reflection;
  stats.rays_shadow = t.rays_shadow;
  stats.rays_ao = t.rays_ao;
  stats.rays_bounce = t.rays_bounce;
  stats.pixels_masked = t.pixels_masked;
  stats.pixels_late = t.pixels_late;
  stats.pixels_older = t.pixels_older;
  stats.mask_pixels_late = t.mask_pixels_late;
  stats.mask_pixels_older = t.mask_pixels_older;
  stats.answer_age = t.answer_age;
  stats.reflection_pixels_late = t.reflection_pixels_late;
  stats.reflection_pixels_older = t.reflection_pixels_older;
  stats.irradiance_pixels_late = t.irradiance_pixels_late;
  stats.irradiance_pixels_older = t.irradiance_pixels_older;
  stats.jobs_starved = t.jobs_starved;
  stats.layers_requested = t.layers_requested;
  stats.layers_found = t.layers_found;
  stats.traversals_wasted = t.traversals_wasted;
  stats.layers_borrowed = t.layers_borrowed;
  stats.layers_refracted = t.layers_refracted;
  stats.bytes_readback = t.bytes_readback;
  stats.bytes_upload = t.bytes_upload;
  stats.bytes_cache = t.bytes_cache;
  stats.layers_matched = counters.fragments.matched;
  stats.layers_missed = counters.fragments.missed;
  stats.layers_misassigned = counters.fragments.misassigned;
  stats.layers_duplicated = counters.duplicated;
}

}  // namespace sideray::bridge
