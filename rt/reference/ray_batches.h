// Traces opaque visibility through pixels, and rays given by the caller. Any thread may call it; an executor takes one
// call at a time.
#pragma once

#include <span>

#include "rt/base/executor.h"
#include "rt/base/opaque_point.h"
#include "rt/base/view.h"
#include "rt/embree/intersector.h"
#include "rt/reference/reference_request.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

PrimaryImage trace_primary_image(const ShadingScene& scene, const Intersector& intersector, Executor& executor,
                                 const TraceView& view, uint32_t width, uint32_t height);

std::vector<OpaquePoint> trace_opaque_points(const ShadingScene& scene, const Intersector& intersector,
                                             Executor& executor, const TraceView& view, uint32_t width,
                                             uint32_t height);

// Finds one hit a ray: the first surface that the rasterizer draws, which excludes backs of materials that are not
// double sided. All rays use `cone` for alpha.
void trace_drawn_surfaces(const Intersector& intersector, const AlphaCone& cone, std::span<const Ray> rays, std::vector<Hit>& hits);

// Rays of a caller, as documented at Tracer::trace_rays.
struct RayBatch {
  sideray_ray_set set;
  std::span<const sideray_ray> rays;
  uint32_t layers;    // surfaces that are wanted of a ray
  sideray_hit* hits;  // room for rays.size() * layers
};
void trace_ray_batch(const model::Snapshot& snapshot, const Intersector& intersector, Executor& executor,
                     const RayBatch& batch);

}  // namespace sideray::rt
