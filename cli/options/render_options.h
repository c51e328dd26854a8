// Holds the options of `sideray render`, parsed once. Any thread.
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

// Holds a pinhole's projection, for any number of pixels: fields of sideray_camera.
struct Projection {
  float yfov;
  float fx_per_fy;
  float shift_x, shift_y;
};

// Says how --max-ms and --max-error chose options.
struct ChoiceSummary {
  std::optional<double> predicted_ms;  // of the whole frame, corrected by frames that missed the bound
  std::optional<double> measured_ms;   // of the whole frame; empty: no bound on the time
  std::optional<double> error;         // mean FLIP on the reduced frame
  size_t corrections = 0;              // how often a measured frame missed the bound, so that the choice was repeated
  double scale = 1;                    // correction factor on times predicted from reduced frames
};

struct RenderOptions {
  Given given;  // as text, for the stats
  std::string scene, output;
  std::string animation;  // "" = the first
  std::string variant;        // of the materials; "" = none
  bool default_light = true;  // for files without lights
  double time_s = 0;
  std::optional<FrameRange> frames;  // of a sequence, whose pattern is `output`
  bool resume = false;               // keeps existing pictures
  bool exr = false;
  std::string camera;  // name or index; "" = first, or else framed
  std::optional<FreeCamera> free_camera;
  std::optional<Projection> projection;  // from --intrinsics, instead of the camera's own
  std::string gl, device, isa;  // device, isa: "" = choose
  uint32_t threads = 0;         // 0 = all
  Options named = Options::create().value();  // the options of the library's table
  bool continues = false;                     // the picture follows the last one
  uint32_t seed_offset = 0;                   // separates the random numbers of pictures with equal options
  uint32_t repeats = 0;                       // of the finished picture, to time it
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  bool raw_frame = false;  // a raw frame is timed
  Aovs aovs;
  std::string environment;
  float environment_scale = 1, environment_rotation_deg = 0;
  lab::Display display;
  lab::CostBounds bounds;
  std::optional<ChoiceSummary> choice;  // empty: nothing was chosen
  std::string stats;      // "" = none
  std::string truth;      // "" = none; a pattern for a sequence
  std::string reference;  // "" = no comparison

  // Returns options for the renderer, which point into this struct.
  sideray_render_options picture() const;
  uint32_t width() const { return named.render().width; }
  uint32_t height() const { return named.render().height; }
  void resize(uint32_t width, uint32_t height);
  sideray_translucency translucency() const { return named.render().translucency->method; }
  // Returns whether everything, or translucent surfaces, are drawn as in the reference.
  bool is_exact() const { return named.render().reference || translucency() == SIDERAY_TRANSLUCENCY_REFERENCE; }
  bool is_hybrid() const { return !named.render().reference && translucency() == SIDERAY_TRANSLUCENCY_HYBRID; }
};

// Returns the given options without those that contradict `--reference`; only options of the library remain.
Given beside_reference(const Given& given);

// Throws UsageError for unknown or contradicting values and values out of range.
RenderOptions resolve_render(const std::string& scene, const Given& given);

}  // namespace sideray::cli
