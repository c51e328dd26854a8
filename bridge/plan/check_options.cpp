#include <sideray/diagnostics.h>

#include <cmath>

#include "bridge/base/lighting.h"
#include "bridge/base/ray_reuse.h"
#include "bridge/plan/render_options.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint64_t most_pixels = uint64_t{1} << 26;
constexpr uint32_t most_poses = 256;

void check_picture(const RenderOptions& o) {
  if (o.width < 1 || o.height < 1 || o.width > 16384 || o.height > 16384 || uint64_t{o.width} * o.height > most_pixels)
    fail(SIDERAY_INVALID_ARGUMENT, "picture of {}x{}: sides must be 1 to 16384 and at most {} pixels in all", o.width,
         o.height, most_pixels);
  if (o.samples < 1 || o.samples > 4096) fail(SIDERAY_INVALID_ARGUMENT, "samples {}: give 1 to 4096", o.samples);
  if (!(o.deadline_ms >= 0.0f) || !std::isfinite(o.deadline_ms))
    fail(SIDERAY_INVALID_ARGUMENT, "deadline_ms {}: give finite milliseconds, or 0 for none", o.deadline_ms);
  if (o.repeats > 10000) fail(SIDERAY_INVALID_ARGUMENT, "repeats {}: give 0 to 10000", o.repeats);
  if (!(std::abs(o.exposure) <= 64.0f)) fail(SIDERAY_INVALID_ARGUMENT, "exposure {}: give -64 to 64 stops", o.exposure);
}

void check_reference(const RenderOptions& o) {
  check_lighting(o.reference->light_samples, o.reference->bounces);
  if (o.shows(SIDERAY_AOV_MASK | SIDERAY_AOV_LAYERS))
    fail(SIDERAY_INVALID_ARGUMENT, "reference: has no mask and no layers to show; leave SIDERAY_AOV_{} out",
         o.shows(SIDERAY_AOV_MASK) ? "MASK" : "LAYERS");
}

void check_shadow_method(const sideray_shadow_options& o) {
  if (o.method < SIDERAY_SHADOWS_OFF || o.method > SIDERAY_SHADOWS_INEXACT)
    fail(SIDERAY_INVALID_ARGUMENT, "shadows {}: give a sideray_shadows", static_cast<int>(o.method));
}

void check_shadows(const sideray_shadow_options& o) {
  check_shadow_method(o);
  if (o.inexact < SIDERAY_EXACT || o.inexact > SIDERAY_INEXACT_ORIGIN)
    fail(SIDERAY_INVALID_ARGUMENT, "inexact {}: give a sideray_inexact", static_cast<int>(o.inexact));
  if (o.inexact_target < SIDERAY_TARGET_MODEL || o.inexact_target > SIDERAY_TARGET_STENCIL)
    fail(SIDERAY_INVALID_ARGUMENT, "inexact_target {}: give a sideray_inexact_target",
         static_cast<int>(o.inexact_target));
  if (!(o.inexact_bias >= 0.0f && std::isfinite(o.inexact_bias)))
    fail(SIDERAY_INVALID_ARGUMENT, "inexact_bias {}: give a finite length of 0 or more", o.inexact_bias);
  if (!(o.bias >= 0.0f && std::isfinite(o.bias)))
    fail(SIDERAY_INVALID_ARGUMENT, "shadow bias {}: give a finite length of 0 or more", o.bias);
}

void check_poses(const sideray_pose_options& o) {
  if (o.poses != SIDERAY_POSES_REST && o.poses != SIDERAY_POSES_ALL && o.poses > most_poses)
    fail(SIDERAY_INVALID_ARGUMENT, "poses {}: give 1 to {}, SIDERAY_POSES_REST or SIDERAY_POSES_ALL", o.poses,
         most_poses);
  if (!(o.cull_angle_deg >= 0.0f && o.cull_angle_deg <= 90.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "cull_angle_deg {}: give 0 to 90", o.cull_angle_deg);
}

void check_layers(const sideray_translucency_options& o) {
  if (o.method == SIDERAY_TRANSLUCENCY_HYBRID && o.layers > 8)
    fail(SIDERAY_INVALID_ARGUMENT, "layers {}: hybrid translucency takes 0 to 8", o.layers);
  if (o.method == SIDERAY_TRANSLUCENCY_RAYTRACED && o.layers > 64)
    fail(SIDERAY_INVALID_ARGUMENT, "layers {}: ray-traced translucency takes 1 to 64, or 0 for unlimited", o.layers);
  if (o.check && o.method != SIDERAY_TRANSLUCENCY_HYBRID)
    fail(SIDERAY_INVALID_ARGUMENT, "check: only hybrid translucency has layers to check; choose it or leave check out");
  if (o.cache_rate < SIDERAY_RATE_FULL || o.cache_rate > SIDERAY_RATE_TEMPORAL8)
    fail(SIDERAY_INVALID_ARGUMENT, "cache_rate {}: give a sideray_cache_rate", static_cast<int>(o.cache_rate));
}

void check_ray_reuse(const sideray_translucency_options& o) {
  if (is_auto_reuse(o)) return;
  if (!(o.ray_reuse >= 0.0f) || !std::isfinite(o.ray_reuse))
    fail(SIDERAY_INVALID_ARGUMENT, "ray_reuse {}: give a finite radiance of 0 or more, or SIDERAY_RAY_REUSE_AUTO",
         o.ray_reuse);
  const char* reason = o.ray_reuse > 0.0f ? why_no_reuse(o) : nullptr;
  if (reason) fail(SIDERAY_INVALID_ARGUMENT, "ray_reuse {}: {}; give AUTO or 0", o.ray_reuse, reason);
}

void check_shading_reuse(const sideray_translucency_options& o) {
  if (is_auto_shading_reuse(o)) return;
  if (!(o.shading_reuse >= 0.0f) || !std::isfinite(o.shading_reuse))
    fail(SIDERAY_INVALID_ARGUMENT,
         "shading_reuse {}: give a finite radiance of 0 or more, or SIDERAY_SHADING_REUSE_AUTO", o.shading_reuse);
  const char* reason = o.shading_reuse > 0.0f ? why_no_shading_reuse(o) : nullptr;
  if (reason) fail(SIDERAY_INVALID_ARGUMENT, "shading_reuse {}: {}; give AUTO or 0", o.shading_reuse, reason);
}

void check_translucency(const sideray_translucency_options& o) {
  if (o.method < SIDERAY_TRANSLUCENCY_OFF || o.method > SIDERAY_TRANSLUCENCY_REFERENCE)
    fail(SIDERAY_INVALID_ARGUMENT, "translucency {}: give a sideray_translucency", static_cast<int>(o.method));
  check_layers(o);
  if (o.oit < SIDERAY_OIT_SORTED || o.oit > SIDERAY_OIT_PEEL)
    fail(SIDERAY_INVALID_ARGUMENT, "oit {}: give a sideray_oit", static_cast<int>(o.oit));
  if (o.mask < SIDERAY_NO_MASK || o.mask > SIDERAY_COUNT_MASK)
    fail(SIDERAY_INVALID_ARGUMENT, "mask {}: give a sideray_mask", static_cast<int>(o.mask));
  if (o.match < SIDERAY_MATCH_ID || o.match > SIDERAY_MATCH_DISTANCE)
    fail(SIDERAY_INVALID_ARGUMENT, "match {}: give a sideray_match", static_cast<int>(o.match));
  if (o.step < SIDERAY_STEP_MULTIHIT || o.step > SIDERAY_STEP_LISTING)
    fail(SIDERAY_INVALID_ARGUMENT, "step {}: give a sideray_step", static_cast<int>(o.step));
  if (!(o.match_threshold > 0.0f && o.match_threshold <= 1.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "match_threshold {}: give a share of the distance, above 0 and at most 1",
         o.match_threshold);
  check_ray_reuse(o);
  check_shading_reuse(o);
  if (o.method == SIDERAY_TRANSLUCENCY_REFERENCE) check_lighting(o.light_samples, o.bounces);
}

}  // namespace

void check_options(const RenderOptions& o) {
  check_picture(o);
  if (o.reference) {
    check_shadow_method(o.shadows);
    check_reference(o);
    return;
  }
  check_translucency(o.translucency);
  check_shadows(o.shadows);
  check_poses(o.poses);
}

}  // namespace sideray::bridge
