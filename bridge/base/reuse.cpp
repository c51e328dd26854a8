#include "bridge/base/reuse.h"

#include <algorithm>

#include "elementary/functions.h"
#include "rt/refraction/refraction.h"

namespace sideray::bridge {
namespace {

// The default bound of `ray_reuse`. It adds at most 0.0007 FLIP in all measured scenes (docs/translucency.md).
constexpr float auto_reuse = 0x1p-6f;

// Converts a bound on the displayed picture to radiance.
float as_shown(float radiance, float exposure) {
  return radiance * elementary::exp2(-std::max(exposure, 0.0f));
}

// `given`: the caller set a bound, which the service refuses together with a host's shader.
LayerUse use_in(const model::Snapshot& snapshot, const RenderOptions& o, bool given) {
  LayerUse use = use_of(o);
  use.follows_refraction = !use.caches && o.translucency.refraction && rt::bends_light(snapshot);
  use.host_shades = !given && snapshot.shader.shade;
  return use;
}

}  // namespace

LayerUse use_of(const sideray_layer_inputs& in, bool host_shades) {
  const bool caches = in.mode == SIDERAY_CACHE;
  return {caches, in.cache_rate, !caches && in.refraction, host_shades};
}

LayerUse use_of(const RenderOptions& o) {
  return {o.is_hybrid(), o.translucency.cache_rate, false, false};
}

const char* why_no_ray_reuse(const LayerUse& use) {
  if (use.caches && use.rate != SIDERAY_RATE_FULL)
    return "every layer that is shaded traces its own rays: the cache rate spares the others";
  if (use.follows_refraction)
    return "every layer traces its own rays: with refraction they hit a surface along several paths";
  if (use.host_shades) return "every layer traces its own rays: a host's shader says itself what its light is";
  return nullptr;
}

ReuseBound ray_reuse_of(const model::Snapshot& snapshot, const RenderOptions& options) {
  const sideray_translucency_options& o = options.translucency;
  if (o.ray_reuse == 0.0f) return {0.0f, nullptr};
  if (const char* reason = why_no_ray_reuse(use_in(snapshot, options, !is_auto_reuse(o)))) return {0.0f, reason};
  return {is_auto_reuse(o) ? as_shown(auto_reuse, options.picture.exposure) : o.ray_reuse, nullptr};
}

}  // namespace sideray::bridge
