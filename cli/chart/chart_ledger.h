// `chart --ledger`: the error of the configuration given, split over the shortcuts it takes (docs/ledger.md). Main
// thread.
#pragma once

#include "cli/chart/chart_folder.h"
#include "cli/session/session.h"

namespace sideray::cli {

// Throws Error where what ledger() writes cannot be.
void prepare_ledger(const ChartFolder& folder);
// What another chart's ledger() wrote.
void remove_ledger(const ChartFolder& folder);

// Draws the configuration without each of its shortcuts, and writes ledger.json, ledger.exr and the pictures. Returns
// what the page shows: ledger.json with a map a term.
lab::Json ledger(const ChartOptions& options, const ChartFolder& folder, Session& session,
                 const lab::ChartReference& reference);

// A table of what ledger() returns.
void print_ledger(const lab::Json& ledger);

}  // namespace sideray::cli
