// The radiance under which a frame skips rays of layers. Any thread.
#pragma once

#include <sideray/renderer.h>

#include "model/snapshot.h"

namespace sideray::bridge {

inline bool is_auto_threshold(const sideray_translucency_options& o) {
  return o.layer_threshold == SIDERAY_LAYER_THRESHOLD_AUTO;
}

// Fragments are blended with weights that depend on all others: nothing bounds what one of them adds to a pixel.
inline bool is_weighted(const sideray_translucency_options& o) {
  return o.method == SIDERAY_TRANSLUCENCY_HYBRID && (o.oit == SIDERAY_OIT_WEIGHTED || o.oit == SIDERAY_OIT_FRONT);
}

// One surface is met along several paths.
inline bool is_refracted(const sideray_translucency_options& o) {
  return o.method == SIDERAY_TRANSLUCENCY_RAYTRACED && o.refraction != 0;
}

// With fewer lights that send any, AUTO comes to 0: rays of one light are seldom skipped, and finding those that can be
// takes up to as long as it saves.
constexpr uint64_t least_lit_lights = 2;

struct LayerThreshold {
  float radiance;            // 0: every ray is traced
  const char* why_no_other;  // static text; null but where AUTO comes to 0
};

// Returns the given radiance, or what AUTO comes to in a frame that traces layers without a reference's samples.
// `exposure` is in stops. Explicit values are those that check_options accepts.
LayerThreshold layer_threshold_of(const model::Snapshot& snapshot, uint64_t lit_lights,
                                  const sideray_translucency_options& options, float exposure);

}  // namespace sideray::bridge
