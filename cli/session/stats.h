// The JSON of --stats: every key is defined in docs/cli.md. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "cli/options/render_options.h"

namespace sideray::cli {

struct RenderRun {
  std::string camera;                        // the one used: a name, an index, or "framed"; "" with --eye
  std::string animation;                     // the one played; "" where there is none
  std::vector<sideray_stage_time> stages;    // in the order of sideray_stage; names live as long as the program
  sideray_device_info device{};              // strings NULL: none yet
  sideray_render_stats stats{};
  sideray_raw_frame raw_frame{};             // ms 0: none was timed
  std::optional<uint32_t> layers;            // that the plan has a use for; empty: nothing was planned
  // These are the values that the plan chose, or took from the options; empty: likewise.
  std::optional<float> ray_reuse;
  std::optional<bool> ao, bounce, reflections;  // that are traced
};

// What does not apply is absent; no null, no NaN.
nlohmann::ordered_json stats_json(const RenderOptions& options, const RenderRun& run);

// "choice" of statistics and plans (docs/cli.md).
nlohmann::ordered_json choice_json(const ChoiceSummary& choice);

// Whether raw frames measure the stage, since it lasts as long as rays and their results do.
bool is_of_rays(const sideray_stage_time& time);

}  // namespace sideray::cli
