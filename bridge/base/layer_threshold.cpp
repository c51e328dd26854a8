#include "bridge/base/layer_threshold.h"

#include <algorithm>
#include <cmath>

#include "rt/refraction/refraction.h"

namespace sideray::bridge {
namespace {

constexpr const char* refracted = "every ray is traced: refracted ones hit a surface along several paths";

// This is a quarter of what 8 bits resolve in white; docs/translucency.md has what it and others change.
constexpr float auto_threshold = 0x1p-10f;

const char* why_none(const model::Snapshot& snapshot, uint64_t lit_lights, float ray_reuse,
                     const sideray_translucency_options& o) {
  if (is_weighted(o)) return "every ray of a layer is traced: weighted blending bounds no surface's share of a pixel";
  if (snapshot.shader.shade)
    return "every ray of a layer is traced: nothing bounds what a host's shader makes of a light";
  if (ray_reuse > 0.0f) return "no ray that is traced is skipped: others borrow what it tells";
  if (lit_lights < least_lit_lights) return "every ray of a layer is traced: under one light hardly any can be skipped";
  return nullptr;
}

}  // namespace

bool follows_refraction(const model::Snapshot& snapshot, const sideray_translucency_options& o) {
  return o.method == SIDERAY_TRANSLUCENCY_RAYTRACED && o.refraction != 0 && rt::bends_light(snapshot);
}

LayerThreshold layer_threshold_of(const model::Snapshot& snapshot, uint64_t lit_lights, float ray_reuse,
                                  const sideray_translucency_options& options, float exposure) {
  if (options.layer_threshold != 0.0f && follows_refraction(snapshot, options)) return {0.0f, refracted};
  if (!is_auto_threshold(options)) return {options.layer_threshold, nullptr};
  if (const char* reason = why_none(snapshot, lit_lights, ray_reuse, options)) return {0.0f, reason};
  // A picture that is shown darker may be kept, and be shown brighter later.
  return {auto_threshold * std::exp2(-std::max(exposure, 0.0f)), nullptr};
}

}  // namespace sideray::bridge
