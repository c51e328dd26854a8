// Decides how much of donors' rays a layer may reuse, and what rules reuse out: the only place of these rules, for
// options, plan and hosts. Any thread.
#pragma once

#include "bridge/base/render_options.h"
#include "model/snapshot.h"

namespace sideray::bridge {

inline bool is_auto_reuse(const sideray_translucency_options& o) {
  return o.ray_reuse == SIDERAY_RAY_REUSE_AUTO;
}

// Holds the properties that rule out reuse.
struct LayerUse {
  bool caches;             // layers are cached, not composited
  sideray_cache_rate rate;  // the rate of the cache
  bool follows_refraction;  // rays are followed from surface to surface, so that they hit a surface along several paths
  bool host_shades;
};

LayerUse use_of(const sideray_layer_inputs& inputs, bool host_shades);
// Returns the properties that options determine.
LayerUse use_of(const RenderOptions& options);

// Returns why every layer traces its own shadow and mirror rays; static text, or null.
const char* why_no_ray_reuse(const LayerUse& use);

struct ReuseBound {
  float radiance;            // 0: nothing is reused
  const char* why_no_other;  // static text: why it is 0 although 0 was not given; otherwise null
};

// Returns the given radiance, or the choice of AUTO in a frame that traces layers without the light samples of a
// reference. check_options() must have accepted explicit values.
ReuseBound ray_reuse_of(const model::Snapshot& snapshot, const RenderOptions& options);

}  // namespace sideray::bridge
