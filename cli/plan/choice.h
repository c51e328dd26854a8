// Chooses, for --max-ms and --max-error, among configurations that the given options leave open. Main thread.
#pragma once

#include "cli/plan/calibration.h"
#include "lab/chart/candidates.h"

namespace sideray::cli {

// Holds one configuration that was considered.
struct Considered {
  lab::Configuration configuration;  // the options besides the given ones
  RenderOptions options;
  lab::Candidate cost;  // look and ms: only where the choice needed them

  // Returns the mean FLIP against the reference; empty: not measured, or unknown.
  std::optional<double> error() const { return cost.look ? cost.look->error : std::nullopt; }
};

struct Choice {
  std::vector<Considered> considered;
  size_t picked = 0;
  lab::Correction correction;  // of predicted times, by whole frames

  const Considered& chosen() const { return considered[picked]; }
  // Returns the corrected predicted time of a configuration; empty where the choice did not need it.
  std::optional<double> foretold_ms(const Considered& c) const;
};

// Measures what the choice needs; with a bound on the time, also the chosen frame as a whole. Throws Error where
// nothing can be drawn, or where no configuration holds the bounds, naming the nearest one.
Choice choose(Session& session, Calibration& calibration, const RenderOptions& options);

// Returns the options completed by the choice; unchanged without bounds. Prints to standard error what was chosen, its
// predicted and measured cost, and how often the choice was repeated.
RenderOptions with_choice(Session& session, const RenderOptions& options);

ChoiceSummary summary(const Choice& choice);

// Returns "translucency hybrid, layers 2, predicted 31.2 ms, measured 33.0 ms, error 0.0123".
std::string describe(const Choice& choice, const Considered& considered);

}  // namespace sideray::cli
