// The radiance under which a frame skips rays of layers. Any thread.
#pragma once

#include <sideray/renderer.h>

#include "model/snapshot.h"

namespace sideray::bridge {

inline bool is_auto_threshold(const sideray_translucency_options& o) {
  return o.layer_threshold == SIDERAY_LAYER_THRESHOLD_AUTO;
}

// Returns whether fragments are blended with weights that depend on all others: nothing bounds then what one of them adds
// to a pixel.
inline bool is_weighted(const sideray_translucency_options& o) {
  return o.method == SIDERAY_TRANSLUCENCY_HYBRID && (o.oit == SIDERAY_OIT_WEIGHTED || o.oit == SIDERAY_OIT_FRONT);
}

// Returns whether rays are followed from surface to surface, because something bends them: they hit a surface along several
// paths. Layers of a cache are not: only what is seen through the last one is followed so.
bool follows_refraction(const model::Snapshot& snapshot, const sideray_translucency_options& o);

// AUTO comes to 0 under fewer lights that send any light, because rays of a single one are seldom skipped, and looking for
// those that can be made the trace take up to 1.29 times as long (panes).
constexpr uint64_t least_lit_lights = 2;

struct LayerThreshold {
  float radiance;            // 0: every ray is traced
  const char* why_no_other;  // static text; null but where 0 was not asked for
};

// Returns the given radiance, 0 where rays follow refraction, or what AUTO comes to in a frame that traces layers without a reference's samples.
// `ray_reuse` is what ray_reuse_of() says, `exposure` is in stops. Explicit values are those that check_options accepts.
LayerThreshold layer_threshold_of(const model::Snapshot& snapshot, uint64_t lit_lights, float ray_reuse,
                                  const sideray_translucency_options& options, float exposure);

}  // namespace sideray::bridge
