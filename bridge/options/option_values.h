// The options of a picture as structs by value, which sideray_render_options points into. Any thread.
#pragma once

#include <sideray/renderer.h>

#include <optional>

#include "bridge/options/presets.h"

namespace sideray::bridge {

// What the rows of the table store their values in. Each field has the default of the public struct until its row has
// stored a value.
struct OptionValues {
  sideray_render_options picture = sideray_render_defaults();  // its pointers are set by OptionSet
  sideray_translucency_options translucency = sideray_translucency_defaults();
  sideray_shadow_options shadows = sideray_shadow_defaults();
  sideray_pose_options poses = sideray_pose_defaults();
  sideray_reference_options reference = sideray_reference_defaults();
  Quality quality = Quality::balanced;  // where options that are not given have their values from
  bool is_reference = false;
  std::optional<uint32_t> surfaces;  // most layers or surfaces of a ray, 0 = unlimited; empty: the method's own default

  bool draws(sideray_translucency method) const { return !is_reference && translucency.method == method; }
  // Translucent surfaces are shaded as in a reference.
  bool is_exact() const { return is_reference || translucency.method == SIDERAY_TRANSLUCENCY_REFERENCE; }
  bool is_hybrid() const { return draws(SIDERAY_TRANSLUCENCY_HYBRID); }
  bool is_raytraced() const { return draws(SIDERAY_TRANSLUCENCY_RAYTRACED); }
  bool traces_shadows() const {
    return !is_reference && (shadows.method == SIDERAY_SHADOWS_EXACT || shadows.method == SIDERAY_SHADOWS_INEXACT);
  }
  bool has_masks() const { return traces_shadows() || (!is_reference && picture.ao != 0); }
};

}  // namespace sideray::bridge
