#include "rt/masks/mask_tracing.h"

#include "model/stopwatch.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/occlusion_masks.h"

namespace sideray::rt {

Counters trace_masks(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks) {
  const model::Snapshot& snapshot = *scene.shading().snapshot;
  Counters counters = trace_occlusion_masks(request, scene, masks);
  if (request.cancelled && *request.cancelled) return counters;
  if (request.filters && !(request.kept && request.kept->keeps_all())) {
    const Stopwatch watch;
    request.filters->filter(scene.executor(), request, snapshot, masks);
    counters.denoise_ms = watch.ms();
  }
  if (request.kept) request.kept->end(masks, !has_passed(request.deadline));
  return counters;
}

}  // namespace sideray::rt
