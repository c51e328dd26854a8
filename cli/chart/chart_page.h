// Makes index.html of a chart: results, pictures, machine and commands in one file. Main thread.
#pragma once

#include "cli/chart/chart_folder.h"

namespace sideray::cli {

struct PagePoint {
  std::string label;
  const RenderOptions* options;
};

// `points`: one for each row of `results`; reads their pictures from the folder. `ledger`: null without one.
std::string chart_page(const ChartOptions& options, const ChartFolder& folder, const std::vector<PagePoint>& points,
                       const lab::Json& results, const lab::Json& ledger);

}  // namespace sideray::cli
