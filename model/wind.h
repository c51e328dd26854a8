// Checks wind as the scene states it, and computes its phases in time and how far it reaches. Any thread may call it.
#pragma once

#include "model/snapshot.h"

namespace sideray::model {

// Throws Failure (INVALID_ARGUMENT) and names the field.
Wind checked_wind(const sideray_wind_desc& desc);

// Returns the cycles of trunk, branches and leaves at a time, each in 0..1; SrWindPhase is made of them.
glm::vec3 wind_phase(const Wind& wind, double time_s, float instance_phase);

// Returns a box in object space around everything in `bounds` at any time.
Bounds reached_in_wind(const Bounds& bounds, const Wind& wind);

}  // namespace sideray::model
