// Finds all surfaces along the rays of a frame's masked pixels without shading them; layer caches are checked against
// them. Any thread may call it.
#pragma once

#include "rt/layers/layer_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Traces what a cache of this request, at any rate, is checked against: as LayerTracing::trace, to the last surface of
// every masked pixel.
LayerTruth trace_layer_truth(const CacheRequest& request, TracedScene& scene);

// Counts layers of the cache that hold the same surface of their pixel as another layer. A layer is taken to hold the
// surface of its id that its distance is nearest to.
uint64_t count_duplicated(const LayerCache& cache, const LayerTruth& truth);

}  // namespace sideray::rt
