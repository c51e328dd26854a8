// What the chunks of a frame are traced with. Immutable while they are; any thread.
#pragma once

#include <cstdint>

#include "rt/base/view_rays.h"
#include "rt/embree/intersector.h"
#include "rt/layers/layer_request.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// What all chunks of a frame share.
struct FrameContext {
  const FrameRequest* request;
  const ViewRays* view;
  const ShadingScene* scene;
  const Intersector* intersector;
  LayerSet set;
  bool cacheable_only;          // skip surfaces that cannot be found again in a layer cache: multiply, without an id
  uint32_t position = 0;        // which of the frame's sample positions: for random numbers
  const float* ends = nullptr;  // of the rays, a texel each, instead of the request's depth
};

}  // namespace sideray::rt
