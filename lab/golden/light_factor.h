// Whether a picture is another one in a brighter or darker light. Plain memory; any thread.
#pragma once

#include <optional>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// The factor by which all light of `now`, radiance before exposure and tone mapping, is that of `reference`, which may be
// radiance or display values; apart from rounding and from one value in a hundred. Empty where there is none, or it is 1.
std::optional<double> light_factor(const scenes::Image& now, const scenes::Image& reference, const Display& display);

}  // namespace sideray::lab
