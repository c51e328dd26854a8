// Lists the configurations from which a bound on time or error chooses. Plain memory; any thread.
#pragma once

#include "lab/chart/configurations.h"

namespace sideray::lab {

struct CandidateConfiguration {
  Configuration configuration;
  std::string drawing, shadows;  // its way of drawing and of shadows; equal texts for equal ways
};

// Returns the usual configuration first, then every way to draw translucency with every way to draw shadows that has an
// effect in the scene, and the choices of a full chart. Configurations leave out the options in `given`, which are
// fixed.
std::vector<CandidateConfiguration> candidate_configurations(const SweepScene& scene, const Configuration& given);

}  // namespace sideray::lab
