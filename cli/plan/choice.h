// --max-ms and --max-error: the configuration that holds them, of those that the given options leave open. Main thread.
#pragma once

#include "cli/plan/calibration.h"
#include "lab/chart/candidates.h"

namespace sideray::cli {

// One configuration that was looked at.
struct Considered {
  lab::Configuration configuration;  // what it says beside the given options
  RenderOptions options;
  lab::Candidate cost;  // look and ms: where the choice needed them

  // Mean FLIP against the reference. Empty: not looked at, or unknown.
  std::optional<double> error() const { return cost.look ? cost.look->error : std::nullopt; }
};

struct Choice {
  std::vector<Considered> considered;
  size_t picked = 0;
  lab::Correction correction;  // what whole frames said of foretold times

  const Considered& chosen() const { return considered[picked]; }
  // Returns the time that is foretold of one by now; nothing where the choice did not need it.
  std::optional<double> foretold_ms(const Considered& c) const;
};

// Measures what the choice needs; with a bound on the time that is the chosen frame too, whole. Throws Error where no
// configuration holds the bounds, with the nearest one and what it reaches, and where nothing can be drawn.
Choice choose(Session& session, Calibration& calibration, const RenderOptions& options);

// The options with what was chosen in place of what was left open; as they are without bounds. Says on standard error
// what was chosen, what it is predicted to cost, what was measured, and how often it was chosen anew.
RenderOptions with_choice(Session& session, const RenderOptions& options);

ChoiceSummary summary(const Choice& choice);

// "translucency hybrid, layers 2, predicted 31.2 ms, measured 33.0 ms, error 0.0123"
std::string describe(const Choice& choice, const Considered& considered);

}  // namespace sideray::cli
