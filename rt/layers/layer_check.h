// Finds all surfaces along the rays of a frame's masked pixels without shading them, to check layer caches against. Any
// thread may call it.
#pragma once

#include "rt/layers/layer_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Traces the surfaces that a cache of this request, at any rate, is checked against: like LayerTracing::trace, but to
// the last surface of every masked pixel.
LayerTruth trace_layer_truth(const CacheRequest& request, TracedScene& scene);

// Counts layers of the cache that repeat a surface of their pixel. A layer stands for the surface with its id whose
// distance is nearest.
uint64_t count_duplicated(const LayerCache& cache, const LayerTruth& truth);

}  // namespace sideray::rt
