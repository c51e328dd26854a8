// Traces opaque visibility through pixels, and rays of the caller's: what the tracer offers besides frames. Any thread
// may call it; an executor takes one call at a time.
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

// Finds the first surfaces that the rasterizer draws, which leaves out the backs of materials that are not double
// sided: one hit a ray. `cone` is common to the rays, for alpha.
void trace_drawn_surfaces(const Intersector& intersector, Cone cone, std::span<const Ray> rays, std::vector<Hit>& hits);

// Traces rays as described at Tracer::trace_rays.
void trace_ray_batch(const model::Snapshot& snapshot, const Intersector& intersector, Executor& executor,
                     sideray_ray_set set, std::span<const sideray_ray> rays, uint32_t layers, sideray_hit* hits);

}  // namespace sideray::rt
