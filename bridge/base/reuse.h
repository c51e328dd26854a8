// Decides how much of other pixels' rays a layer may reuse, and what rules that out: the one place of these rules, for
// options, plan and hosts. Any thread.
#pragma once

#include "bridge/base/render_options.h"
#include "model/snapshot.h"

namespace sideray::bridge {

inline bool is_auto_reuse(const sideray_translucency_options& o) {
  return o.ray_reuse == SIDERAY_RAY_REUSE_AUTO;
}

// Holds what rules out reuse.
struct LayerUse {
  bool caches;             // layers are cached, not composited
  sideray_cache_rate rate;  // where they are cached
  bool follows_refraction;  // rays are followed from surface to surface: they hit a surface along several paths
  bool host_shades;
};

LayerUse use_of(const sideray_layer_inputs& inputs, bool host_shades);
// Returns as much of it as options say.
LayerUse use_of(const RenderOptions& options);

// Returns why every layer traces its own shadow and mirror rays; static text, or null.
const char* why_no_ray_reuse(const LayerUse& use);

struct ReuseBound {
  float radiance;            // 0: nothing is reused
  const char* why_no_other;  // static text; null but where 0 was not asked for
};

// Returns the given radiance, or what AUTO comes to in a frame that traces layers without a reference's samples.
// Explicit values are those that check_options() accepts.
ReuseBound ray_reuse_of(const model::Snapshot& snapshot, const RenderOptions& options);

}  // namespace sideray::bridge
