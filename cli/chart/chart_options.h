// Resolves the options of `sideray chart`, and those of each of its pictures. Any thread.
#pragma once

#include "cli/options/render_options.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

struct ChartOptions {
  Given given;
  std::string scene, folder;
  std::string sweep;                   // as given
  std::optional<lab::Sweep> built_in;  // empty: it is a file
  std::optional<FrameRange> frames;    // only of a sequence
  uint32_t repeats = 5;
  TaskShard shard;
  bool resume = false;
  bool ledger = false;  // also splits the error of the given configuration
  std::string metric;
};

// The options of `render` that apply, and the chart's own.
const Table& chart_table();

// Throws UsageError.
ChartOptions resolve_chart(const std::string& scene, const Given& given);

// `name` precedes errors about the configuration. `image`: the file of its picture. Throws UsageError.
RenderOptions resolve_row(const ChartOptions& options, const lab::Configuration& configuration, const std::string& name,
                          const std::string& image);
RenderOptions resolve_reference(const ChartOptions& options, const std::string& image);
// Returns options that draw only motion, from frame to frame.
RenderOptions resolve_motion(const ChartOptions& options, const std::string& image);

}  // namespace sideray::cli
