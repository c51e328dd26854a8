// Recognizes a picture that differs from another only by a brighter or darker light. Plain memory; any thread.
#pragma once

#include <optional>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// Returns the factor between the light of `reference` and that of `now`, up to rounding and one value in a hundred.
// `now` is radiance before exposure and tone mapping; `reference` is that, or display values. Empty where no factor
// fits, or it is 1.
std::optional<double> light_factor(const scenes::Image& now, const scenes::Image& reference, const Display& display);

}  // namespace sideray::lab
