// Tests whether a picture is another one in brighter or darker light. Plain memory; any thread.
#pragma once

#include <optional>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// Returns the factor between all light of `now` (radiance before exposure and tone mapping) and of `reference`
// (radiance or display values), apart from rounding and one value in a hundred. Empty if there is no such factor, or it
// is 1.
std::optional<double> light_factor(const scenes::Image& now, const scenes::Image& reference, const Display& display);

}  // namespace sideray::lab
