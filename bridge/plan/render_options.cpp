#include "bridge/plan/render_options.h"

#include "bridge/base/versions.h"

namespace sideray::bridge {
namespace {

sideray_translucency_options read_translucency(const sideray_translucency_options* given) {
  if (given) return read_struct(given, "translucency options", sideray_translucency_init);
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

template <typename T>
std::optional<T> read_optional(const T* given, const char* name, void (*init)(T*, size_t)) {
  return given ? std::optional(read_struct(given, name, init)) : std::nullopt;
}

}  // namespace

RenderOptions read_render_options(const sideray_render_options* given) {
  const sideray_render_options o = read_struct(given, "render options", sideray_render_init);
  const auto diagnostics = read_optional(o.diagnostics, "diagnostics", sideray_diagnostics_init);
  const sideray_raw_frame* raw_frame = diagnostics ? diagnostics->raw_frame : nullptr;
  return {.width = o.width,
          .height = o.height,
          .samples = o.samples,
          .seed = o.seed,
          .translucency = read_translucency(o.translucency),
          .shadows = read_shadows(o.shadows),
          .poses = read_poses(o.poses),
          .reference = read_optional(o.reference, "reference options", sideray_reference_init),
          .reflections = o.reflections == SIDERAY_REFLECTIONS_AUTO ? o.reflections : o.reflections != 0,
          .ao = o.ao == SIDERAY_AO_AUTO ? o.ao : o.ao != 0,
          .denoise = o.denoise != 0,
          .taa = o.taa != 0,
          .continues = o.continues != 0,
          .deadline_ms = o.deadline_ms,
          .aovs = o.aovs,
          .repeats = o.repeats,
          .exact_points = diagnostics && diagnostics->exact_points != 0,
          .raw_frame = diagnostics ? diagnostics->raw_frame : nullptr,
          .most_flat_triangles =
              raw_frame ? read_struct(raw_frame, "raw frame", sideray_raw_frame_init).most_flat_triangles : 0,
          .exposure = o.exposure};
}

}  // namespace sideray::bridge
