// Wind as the scene states it: checks, phases in time, how far it reaches. Any thread.
#pragma once

#include "model/snapshot.h"

namespace sideray::model {

// Throws Failure (INVALID_ARGUMENT) and names the field.
Wind checked_wind(const sideray_wind_desc& desc);

// Cycles of trunk, branches and leaves at a time, each in 0..1; what SrWindPhase is made of.
glm::vec3 wind_phase(const Wind& wind, double time_s, float instance_phase);

// For each instance the number of earlier ones with the same mesh and wind: the first ones of a kind have a pose of
// their own where not all can (sideray_foliage). 0 without wind.
std::vector<uint32_t> ranks_in_wind(const Snapshot& snapshot);

// A box in object space around everything in `bounds` at any time.
Bounds reached_in_wind(const Bounds& bounds, const Wind& wind);

}  // namespace sideray::model
