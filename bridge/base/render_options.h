// Holds the options of a picture by value, whatever version the public structs had. Any thread.
#pragma once

#include <sideray/diagnostics.h>

namespace sideray::bridge {

// Each part starts with the defaults of its public struct.
struct RenderOptions {
  sideray_render_options picture = sideray_render_defaults();  // without pointers: the parts are below
  sideray_translucency_options translucency = sideray_translucency_defaults();
  sideray_shadow_options shadows = sideray_shadow_defaults();
  sideray_pose_options poses = sideray_pose_defaults();
  sideray_reference_options reference = sideray_reference_defaults();  // only with is_reference
  bool is_reference = false;
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  uint64_t most_flat_triangles = 0;  // for the raw frame of the diagnostics

  bool shows(uint32_t any_of_aovs) const { return (picture.aovs & any_of_aovs) != 0; }
  bool draws(sideray_translucency method) const;
  // Returns whether translucent surfaces are shaded as in a reference.
  bool is_exact() const;
  bool is_hybrid() const { return draws(SIDERAY_TRANSLUCENCY_HYBRID); }
  bool is_raytraced() const { return draws(SIDERAY_TRANSLUCENCY_RAYTRACED); }
  bool traces_shadows() const;
  // Returns whether a frame may end before all rays are traced.
  bool is_bounded() const { return picture.budget_ms > 0.0f || picture.deadline_ms > 0.0f || diagnostics.budget_pieces > 0; }
  bool has_masks() const { return traces_shadows() || (!is_reference && picture.ambient != SIDERAY_AMBIENT_OFF); }
};

// Throws Failure (INVALID_ARGUMENT, UNSUPPORTED) where a struct's version is unknown. A part that the caller left out
// is off: no translucency, no shadows, every instance in its drawn pose.
RenderOptions read_render_options(const sideray_render_options* given);

}  // namespace sideray::bridge
