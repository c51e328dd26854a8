// What a chart prints when all is measured. Main thread.
#pragma once

#include "cli/chart/chart_page.h"

namespace sideray::cli {

void print_noise(const lab::Json& results);
void print_table(const std::vector<PagePoint>& points, const lab::Json& results, const ChartOptions& options);

}  // namespace sideray::cli
