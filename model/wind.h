// Checks the scene's wind, and computes its phases in time and its range. Any thread may call it.
#pragma once

#include "model/snapshot.h"

namespace sideray::model {

// Throws Failure (INVALID_ARGUMENT) that names the field.
Wind checked_wind(const sideray_wind_desc& desc);

// Returns the cycles of trunk, branches and leaves at a time, each in 0..1, for SrWindPhase.
glm::vec3 wind_phase(const Wind& wind, double time_s, float instance_phase);

// Returns a box in object space around everything in `bounds` at any time.
Bounds reached_in_wind(const Bounds& bounds, const Wind& wind);

}  // namespace sideray::model
