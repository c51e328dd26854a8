// The options of a picture by value, whatever version of the public structs they came in. Any thread.
#pragma once

#include <sideray/diagnostics.h>

#include <optional>

namespace sideray::bridge {

struct RenderOptions {
  uint32_t width, height;
  uint32_t samples;
  uint32_t seed;
  sideray_translucency_options translucency;  // OFF where the caller gave none
  sideray_shadow_options shadows;             // OFF where the caller gave none
  sideray_pose_options poses;                 // every instance as it is drawn, where the caller gave none
  std::optional<sideray_reference_options> reference;
  int32_t reflections, ao;  // 0, 1 or AUTO
  bool denoise, taa, continues;
  float deadline_ms;
  uint32_t aovs;
  uint32_t repeats;
  bool exact_points;             // diagnostics.h
  sideray_raw_frame* raw_frame;  // diagnostics.h; the caller's
  uint64_t most_flat_triangles;  // of raw_frame
  float exposure;                // stops that the picture is shown brighter by

  bool shows(uint32_t any_of_aovs) const { return (aovs & any_of_aovs) != 0; }
};

// Throws Failure (INVALID_ARGUMENT, UNSUPPORTED) where a struct is of no known version.
RenderOptions read_render_options(const sideray_render_options* given);

// Throws Failure (INVALID_ARGUMENT) and names the option. What a reference does not read is not checked with it.
void check_options(const RenderOptions& options);

}  // namespace sideray::bridge
