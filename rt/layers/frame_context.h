// Holds what the chunks of a frame are traced with. Immutable while they are traced; any thread may read it.
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
  // Where layers are cached, the same request; surfaces that cannot be found again in a layer cache are skipped then:
  // multiply ones, and those without an id.
  const CacheRequest* cache = nullptr;
  const ViewRays* view;
  const ShadingScene* scene;
  const Intersector* intersector;
  LayerSet set;
  // Where surfaces are cached that bend light, one for each material: 1 = straight rays end at its surfaces. Or empty.
  std::span<const uint8_t> bends = {};
  uint32_t position = 0;        // which of the frame's sample positions: for random numbers
  const class SpriteLights* sprites = nullptr;  // precomputed light of sprites; null: they are shaded as others are
  const float* ends = nullptr;  // of the rays, a texel each, instead of the request's depth
};

}  // namespace sideray::rt
