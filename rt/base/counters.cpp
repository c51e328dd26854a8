#include "rt/base/counters.h"

namespace sideray::rt {

void TraceCounters::operator+=(const TraceCounters& b) {
  rays_primary += b.rays_primary, rays_reflection += b.rays_reflection, rays_shadow += b.rays_shadow;
  rays_ao += b.rays_ao;
  pixels_masked += b.pixels_masked;
  layers_requested += b.layers_requested, layers_found += b.layers_found, layers_shaded += b.layers_shaded;
  traversals_wasted += b.traversals_wasted;
  rays_skipped += b.rays_skipped, layers_skipped += b.layers_skipped;
  points_shaded += b.points_shaded, points_not_finite += b.points_not_finite;
  pixels_late += b.pixels_late;
}

}  // namespace sideray::rt
