// What `sideray render` was asked for, read once from the options that were given. Any thread.
#pragma once

#include <array>
#include <optional>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "cli/options/aovs.h"
#include "cli/options/comparison.h"
#include "cli/options/frame_range.h"
#include "cli/options/options.h"
#include "cli/options/render_table.h"
#include "lab/prediction/picking.h"
#include "scenes/images/images.h"

namespace sideray::cli {

struct FreeCamera {
  std::array<double, 3> eye, target;
  float fov_deg = 45;
};

struct RenderOptions {
  Given given;  // as text, for the stats
  std::string scene, output;
  std::string animation;  // "" = the first
  double time_s = 0;
  std::optional<FrameRange> frames;  // a sequence: output is its pattern
  bool resume = false;               // what exists stays
  bool exr = false;
  std::string camera;  // name or index; "" = first, else framed
  std::optional<FreeCamera> free_camera;
  std::string gl, device, isa;  // device, isa: "" = choose
  uint32_t threads = 0;         // 0 = all
  std::string ray_traced;
  sideray_render_options options;
  Aovs aovs;
  std::string environment;
  float environment_scale = 1, environment_rotation_deg = 0;
  lab::Display display;
  lab::CostBounds bounds;
  std::string stats;      // "" = none
  std::string reference;  // "" = no comparison
  ComparisonOptions comparison;
};

// Without what `--reference` decides itself.
void erase_overridden(Given& given);

// Throws UsageError: unknown or contradicting values, values out of range, what is not built yet.
RenderOptions resolve_render(const std::string& scene, const Given& given);

}  // namespace sideray::cli
