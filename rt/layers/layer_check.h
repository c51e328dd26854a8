// All surfaces along the rays of a frame's masked pixels, nothing shaded: what a layer cache is checked against. Any
// thread.
#pragma once

#include "rt/layers/layer_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Traces what a cache of this request, at any rate, is checked against: as LayerTracing::trace, to the last surface of
// every masked pixel.
LayerTruth trace_layer_truth(const CacheRequest& request, TracedScene& scene);

// Layers of the cache that hold the same surface of their pixel as another layer. A layer is the surface of its id that
// its distance is nearest to.
uint64_t count_duplicated(const LayerCache& cache, const LayerTruth& truth);

}  // namespace sideray::rt
