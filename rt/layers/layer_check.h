// Finds all surfaces along the rays of a frame's masked pixels without shading them; layer caches are checked against
// them. Any thread may call it.
#pragma once

#include "rt/base/executor.h"
#include "rt/embree/intersector.h"
#include "rt/layers/layer_request.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Traces as trace_cache does, but to the last surface of every masked pixel.
LayerTruth trace_layer_truth(const FrameRequest& request, const ShadingScene& scene, const Intersector& intersector,
                             Executor& executor);

// Counts layers of the cache that hold the same surface of their pixel as another layer. A layer is taken to hold the
// surface of its id that its distance is nearest to.
uint64_t count_duplicated(const LayerCache& cache, const LayerTruth& truth);

}  // namespace sideray::rt
