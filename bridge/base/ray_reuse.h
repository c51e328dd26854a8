// Decides by how much donors of a frame, whose rays neighbours reuse, may differ, and by how much the reused light of
// layers may change from frame to frame. Any thread may call it.
#pragma once

#include <sideray/renderer.h>

#include "model/snapshot.h"

namespace sideray::bridge {

inline bool is_auto_reuse(const sideray_translucency_options& o) {
  return o.ray_reuse == SIDERAY_RAY_REUSE_AUTO;
}

struct ReuseBound {
  float radiance;            // 0: every layer traces its own rays
  const char* why_no_other;  // static text; null but where 0 was not asked for
};

// Returns why the options rule ray reuse out, static text, or null.
const char* why_no_reuse(const sideray_translucency_options& options);

// Returns the given radiance, 0 where rays follow refraction, or what AUTO comes to in a frame that traces layers without a reference's samples.
// `exposure` is in stops. Explicit values are those that check_options accepts.
ReuseBound ray_reuse_of(const model::Snapshot& snapshot, const sideray_translucency_options& options, float exposure);

inline bool is_auto_shading_reuse(const sideray_translucency_options& o) {
  return o.shading_reuse == SIDERAY_SHADING_REUSE_AUTO;
}

// The same for layers that take their light from the frame before.
const char* why_no_shading_reuse(const sideray_translucency_options& options);
ReuseBound shading_reuse_of(const model::Snapshot& snapshot, const sideray_translucency_options& options,
                            float exposure);

}  // namespace sideray::bridge
