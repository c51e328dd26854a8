// The configurations that a bound on time or error chooses from. Plain memory; any thread.
#pragma once

#include "lab/configurations.h"

namespace sideray::lab {

// Every way to draw translucency with every way to draw shadows, as far as the scene has a use for them, and what else
// a chart of everything would draw with the same light. Options in `given` stay as they are: no configuration names
// them.
std::vector<Configuration> candidate_configurations(const SweepScene& scene, const Configuration& given);

}  // namespace sideray::lab
