// What `sideray chart` was asked for, and what of it each of its pictures takes. Any thread.
#pragma once

#include "cli/options/render_options.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

struct ChartOptions {
  Given given;
  std::string scene, folder;
  std::string sweep;                   // as it was given
  std::optional<lab::Sweep> built_in;  // else it is a file
  std::optional<FrameRange> frames;    // of a sequence
  uint32_t repeats = 5;
  TaskShard shard;
  bool resume = false;
  bool ledger = false;  // also splits the error of the configuration given
  std::string metric;
};

// The options of `render` that apply, and chart's own.
const Table& chart_table();

// Throws UsageError.
ChartOptions resolve_chart(const std::string& scene, const Given& given);

// `name` stands before what is wrong with the configuration. `image`: where its picture goes. Throws UsageError.
RenderOptions resolve_row(const ChartOptions& options, const lab::Configuration& configuration, const std::string& name,
                          const std::string& image);
RenderOptions resolve_reference(const ChartOptions& options, const std::string& image);
// What shows how everything moves from frame to frame, and nothing else.
RenderOptions resolve_motion(const ChartOptions& options, const std::string& image);

}  // namespace sideray::cli
