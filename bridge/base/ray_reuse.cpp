#include "bridge/base/ray_reuse.h"

#include <algorithm>
#include <cmath>

#include "rt/refraction/refraction.h"

namespace sideray::bridge {
namespace {

// At this bound no scene that was measured is farther off the reference by more than 0.0007 FLIP (docs/ray-reuse.md).
constexpr float auto_reuse = 0x1p-6f;

// At this bound frames of a moving camera are farther off the reference by about 0.0001 FLIP (docs/shading-reuse.md).
constexpr float auto_shading_reuse = 0x1p-8f;

// Returns whether rays are followed from surface to surface, because something bends them: they hit a surface along several
// paths. Layers of a cache are not: only what is seen through the last one is followed so.
bool follows_refraction(const model::Snapshot& snapshot, const sideray_translucency_options& o) {
  return o.method == SIDERAY_TRANSLUCENCY_RAYTRACED && o.refraction != 0 && rt::bends_light(snapshot);
}

}  // namespace

const char* why_no_reuse(const sideray_translucency_options& o) {
  if (o.method == SIDERAY_TRANSLUCENCY_HYBRID && o.cache_rate != SIDERAY_RATE_FULL)
    return "every layer that is shaded traces its own rays: the cache rate spares the others";
  return nullptr;
}

ReuseBound ray_reuse_of(const model::Snapshot& snapshot, const sideray_translucency_options& o, float exposure) {
  if (o.ray_reuse != 0.0f && follows_refraction(snapshot, o))
    return {0.0f, "every layer traces its own rays: refracted ones hit a surface along several paths"};
  if (!is_auto_reuse(o)) return {o.ray_reuse, nullptr};
  if (const char* reason = why_no_reuse(o)) return {0.0f, reason};
  if (snapshot.shader.shade)
    return {0.0f, "every layer traces its own rays: a host's shader says itself what its light is"};
  return {auto_reuse * std::exp2(-std::max(exposure, 0.0f)), nullptr};
}

const char* why_no_shading_reuse(const sideray_translucency_options& o) {
  if (o.cache_rate != SIDERAY_RATE_FULL)
    return "layers are shaded at the cache rate: it spares some of them already";
  return nullptr;
}

ReuseBound shading_reuse_of(const model::Snapshot& snapshot, const sideray_translucency_options& o, float exposure) {
  if (!is_auto_shading_reuse(o)) return {o.shading_reuse, nullptr};
  if (o.method != SIDERAY_TRANSLUCENCY_HYBRID) return {0.0f, nullptr};
  if (const char* reason = why_no_shading_reuse(o)) return {0.0f, reason};
  if (snapshot.shader.shade) return {0.0f, "every layer is shaded: a host's shader says itself what its light is"};
  return {auto_shading_reuse * std::exp2(-std::max(exposure, 0.0f)), nullptr};
}

}  // namespace sideray::bridge
