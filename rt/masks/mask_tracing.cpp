#include "rt/masks/mask_tracing.h"

#include "model/stopwatch.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/occlusion_masks.h"

namespace sideray::rt {

Counters trace_masks(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks) {
  const model::Snapshot& snapshot = *scene.shading().snapshot;
  Counters counters = trace_occlusion_masks(request, scene, masks);
  if (!request.filters || (request.cancelled && *request.cancelled)) return counters;
  const Stopwatch watch;
  request.filters->filter(scene.executor(), request, snapshot, masks);
  counters.denoise_ms = watch.ms();
  return counters;
}

}  // namespace sideray::rt
