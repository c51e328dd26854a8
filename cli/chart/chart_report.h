// Writes and prints a chart whose rows are all measured. Main thread.
#pragma once

#include <span>

#include "cli/chart/chart_page.h"

namespace sideray::cli {

// Writes results.json, results.csv and the page, and prints the table: `shown` and `rows` are the chart's points,
// `ledger` null without one. Returns the exit code: failed if a pixel is not finite. Throws Error.
int write_chart(const ChartOptions& options, const ChartFolder& folder, const lab::ChartReference& reference,
                const std::vector<PagePoint>& shown, std::span<const lab::ChartRow> rows, const lab::Json& ledger);

}  // namespace sideray::cli
