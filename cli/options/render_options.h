// Holds what `sideray render` was asked for, read once from the options that were given. Any thread.
#pragma once

#include <sideray/diagnostics.h>

#include <array>
#include <optional>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "cli/options/aovs.h"
#include "cli/options/frame_range.h"
#include "cli/options/render_table.h"
#include "lab/metrics/metrics.h"
#include "lab/prediction/picking.h"
#include "scenes/images/images.h"

namespace sideray::cli {

struct FreeCamera {
  std::array<double, 3> eye, target;
  float fov_deg = 45;
};

// How a pinhole projects, whatever the number of pixels that it is drawn with: the fields of sideray_camera.
struct Projection {
  float yfov;
  float fx_per_fy;
  float shift_x, shift_y;
};

// How options were chosen by --max-ms and --max-error.
struct ChoiceSummary {
  std::optional<double> predicted_ms;  // of the whole frame, with what was learned from frames that missed the bound
  std::optional<double> measured_ms;   // of the whole frame; empty: there was no bound on the time
  std::optional<double> error;         // mean FLIP on the reduced frame
  size_t corrections = 0;              // how often a measured frame missed the bound, so that it was chosen anew
  double scale = 1;                    // times that reduced frames foretell were taken to be so many times as long
};

struct RenderOptions {
  Given given;  // as text, for the stats
  std::string scene, output;
  std::string animation;  // "" = the first
  std::string variant;        // of the materials; "" = none
  bool default_light = true;  // of a file without lights
  double time_s = 0;
  std::optional<FrameRange> frames;  // a sequence: output is its pattern
  bool resume = false;               // what exists stays
  bool exr = false;
  std::string camera;  // name or index; "" = first, else framed
  std::optional<FreeCamera> free_camera;
  std::optional<Projection> projection;  // of --intrinsics, in place of the camera's own
  std::string gl, device, isa;  // device, isa: "" = choose
  uint32_t threads = 0;         // 0 = all
  Options named = Options::create().value();  // what the library's table has
  bool continues = false;                     // the picture follows the last one
  uint32_t seed_offset = 0;                   // of this picture among others that are drawn with the same options
  uint32_t repeats = 0;                       // after the picture itself, to time it
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  bool raw_frame = false;  // is to be timed
  Aovs aovs;
  std::string environment;
  float environment_scale = 1, environment_rotation_deg = 0;
  lab::Display display;
  lab::CostBounds bounds;
  std::optional<ChoiceSummary> choice;  // empty: nothing was chosen
  std::string stats;      // "" = none
  std::string truth;      // "" = none; of a sequence a pattern
  std::string reference;  // "" = no comparison

  // For the renderer. It points into this.
  sideray_render_options picture() const;
  uint32_t width() const { return named.render().width; }
  uint32_t height() const { return named.render().height; }
  void resize(uint32_t width, uint32_t height);
  sideray_translucency translucency() const { return named.render().translucency->method; }
  // Everything, or translucent surfaces, as in the reference.
  bool is_exact() const { return named.render().reference || translucency() == SIDERAY_TRANSLUCENCY_REFERENCE; }
  bool is_hybrid() const { return !named.render().reference && translucency() == SIDERAY_TRANSLUCENCY_HYBRID; }
};

// Leaves out what contradicts `--reference`, which is not among `given`: the library's options alone stay.
Given beside_reference(const Given& given);

// Throws UsageError for unknown or contradicting values and values out of range.
RenderOptions resolve_render(const std::string& scene, const Given& given);

}  // namespace sideray::cli
