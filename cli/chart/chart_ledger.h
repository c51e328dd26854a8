// `chart --ledger`: splits the error of the given configuration over its shortcuts (docs/ledger.md). Main thread.
#pragma once

#include "cli/chart/chart_folder.h"
#include "cli/session/session.h"

namespace sideray::cli {

// Throws Error where ledger() could not write its files.
void prepare_ledger(const ChartFolder& folder);
// Removes what ledger() wrote for an earlier chart.
void remove_ledger(const ChartFolder& folder);

// Draws the configuration without each of its shortcuts, and writes ledger.json, ledger.exr and the pictures. Returns
// the content of the page: ledger.json with a map for each term.
lab::Json ledger(const ChartOptions& options, const ChartFolder& folder, Session& session,
                 const lab::ChartReference& reference);

// Prints what ledger() returns as a table.
void print_ledger(const lab::Json& ledger);

}  // namespace sideray::cli
