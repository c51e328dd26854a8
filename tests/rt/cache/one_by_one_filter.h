// Filters layers as LayerFilter does, one by one, as the reference for its kernels' bits.
#pragma once

#include <vector>

#include "rt/cache/layer_cache.h"
#include "rt/cache/layer_filter.h"

namespace sideray::rt {

void filter_one_by_one(const std::vector<LayerFilter::Chunk>& chunks, LayerCache& cache);

}  // namespace sideray::rt
