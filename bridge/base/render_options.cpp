#include "bridge/base/render_options.h"

#include "bridge/base/versions.h"

namespace sideray::bridge {
namespace {

sideray_translucency_options read_translucency(const sideray_translucency_options* given) {
  if (given) {
    sideray_translucency_options read = read_struct(given, "translucency options", sideray_translucency_init);
    read.cache_rate = read_rate(read.cache_rate);
    return read;
  }
  sideray_translucency_options none = sideray_translucency_defaults();
  none.method = SIDERAY_TRANSLUCENCY_OFF;
  return none;
}

sideray_shadow_options read_shadows(const sideray_shadow_options* given) {
  if (given) return read_struct(given, "shadow options", sideray_shadow_init);
  sideray_shadow_options none = sideray_shadow_defaults();
  none.method = SIDERAY_SHADOWS_OFF;
  return none;
}

sideray_pose_options read_poses(const sideray_pose_options* given) {
  if (given) return read_struct(given, "pose options", sideray_pose_init);
  sideray_pose_options as_drawn = sideray_pose_defaults();
  as_drawn.poses = SIDERAY_POSES_ALL;
  as_drawn.cull_angle_deg = 0.0f;
  return as_drawn;
}

}  // namespace

bool RenderOptions::draws(sideray_translucency method) const {
  return !is_reference && translucency.method == method;
}

bool RenderOptions::is_exact() const {
  return is_reference || translucency.method == SIDERAY_TRANSLUCENCY_REFERENCE;
}

bool RenderOptions::traces_shadows() const {
  return !is_reference && (shadows.method == SIDERAY_SHADOWS_EXACT || shadows.method == SIDERAY_SHADOWS_INEXACT);
}

RenderOptions read_render_options(const sideray_render_options* given) {
  RenderOptions o;
  o.picture = read_struct(given, "render options", sideray_render_init);
  o.translucency = read_translucency(o.picture.translucency);
  o.shadows = read_shadows(o.picture.shadows);
  o.poses = read_poses(o.picture.poses);
  o.is_reference = o.picture.reference != nullptr;
  if (o.is_reference) o.reference = read_struct(o.picture.reference, "reference options", sideray_reference_init);
  if (o.picture.diagnostics)
    o.diagnostics = read_struct(o.picture.diagnostics, "diagnostics", sideray_diagnostics_init);
  if (o.diagnostics.raw_frame)
    o.most_flat_triangles = read_struct(o.diagnostics.raw_frame, "raw frame", sideray_raw_frame_init).most_flat_triangles;
  // Clears the pointers, since the parts may be gone after the call.
  o.picture.translucency = nullptr;
  o.picture.shadows = nullptr;
  o.picture.poses = nullptr;
  o.picture.reference = nullptr;
  o.picture.diagnostics = nullptr;
  return o;
}

}  // namespace sideray::bridge
