// Holds the data that the chunks of a frame are traced with. Immutable during tracing; any thread may read it.
#pragma once

#include <cstdint>
#include <span>

#include "rt/base/view_rays.h"
#include "rt/embree/intersector.h"
#include "rt/layers/layer_request.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Holds what all chunks of a frame share.
struct FrameContext {
  const LayerRequest* request;
  // The same request if layers are cached, else null. Surfaces that a layer cache cannot match are then skipped: those
  // that multiply, and those without an id.
  const CacheRequest* cache = nullptr;
  const ViewRays* view;
  const ShadingScene* scene;
  const Intersector* intersector;
  LayerSet set;
  // By material, if surfaces that bend light are cached: 1 = straight rays end at its surfaces. Otherwise empty.
  std::span<const uint8_t> bends = {};
  uint32_t position = 0;        // index of the frame's sample position, for random numbers
  const class SpriteLights* sprites = nullptr;  // precomputed light of sprites; null: they are shaded like other
                                                // surfaces
  const float* ends = nullptr;  // ends of the rays, one a texel, instead of the request's depth
};

}  // namespace sideray::rt
