// Lists the configurations that a bound on time or error chooses from. Plain memory; any thread.
#pragma once

#include "lab/chart/configurations.h"

namespace sideray::lab {

struct CandidateConfiguration {
  Configuration configuration;
  std::string drawing, shadows;  // its options of each kind, as text: equal where the options are equal
};

// Returns the usual configuration first, then every way to draw translucency with every way to draw shadows, as far as
// the scene has a use for them, and the choices of a chart of everything. No configuration names an option of `given`:
// its value stays.
std::vector<CandidateConfiguration> candidate_configurations(const SweepScene& scene, const Configuration& given);

}  // namespace sideray::lab
