// Holds what the chunks of a frame are traced with. Immutable while they are traced; any thread may read it.
#pragma once

#include <cstdint>

#include "rt/base/view_rays.h"
#include "rt/embree/intersector.h"
#include "rt/layers/layer_request.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Holds what all chunks of a frame share.
struct FrameContext {
  const FrameRequest* request;
  const ViewRays* view;
  const ShadingScene* scene;
  const Intersector* intersector;
  LayerSet set;
  bool cacheable_only;          // skip surfaces that cannot be found again in a layer cache: multiply, without an id
  uint32_t position = 0;        // index among the frame's sample positions: for random numbers
  const float* ends = nullptr;  // the ends of the rays, one a texel, instead of the request's depth
};

}  // namespace sideray::rt
