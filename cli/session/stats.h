// Makes the JSON of --stats, whose keys docs/cli.md defines. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "cli/options/render_options.h"

namespace sideray::cli {

struct RenderRun {
  std::string camera;                        // in use: a name, an index, or "framed"; "" with --eye
  std::string animation;                     // in use; "" where there is none
  std::vector<sideray_stage_time> stages;    // in the order of sideray_stage; names are never freed
  sideray_device_info device{};              // strings NULL: none yet
  sideray_render_stats stats{};
  sideray_raw_frame raw_frame{};             // ms 0: none was timed
  std::optional<uint32_t> layers;            // number that the plan uses; empty: nothing was planned
  // Values that the plan chose, or took from the options; empty: nothing was planned.
  std::optional<float> ray_reuse;
  std::optional<bool> ao, bounce, reflections;  // whether they are traced
};

// Omits what does not apply; no null, no NaN.
nlohmann::ordered_json stats_json(const RenderOptions& options, const RenderRun& run);

// Returns "choice" of statistics and plans (docs/cli.md).
nlohmann::ordered_json choice_json(const ChoiceSummary& choice);

// Returns whether the stage is also stated in raw frames, because its time is that of rays or of their results.
bool is_of_rays(const sideray_stage_time& time);

}  // namespace sideray::cli
