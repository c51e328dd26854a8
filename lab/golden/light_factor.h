// Whether a picture is another one in a brighter or darker light. Plain memory; any thread.
#pragma once

#include <optional>

#include "scenes/images/images.h"

namespace sideray::lab {

// The factor by which all colours of `now` are those of `reference`, apart from rounding and from one pixel in a hundred;
// empty where there is none, or it is 1. Of display values it is exact but for the shoulder and the toe of a tone curve.
std::optional<double> light_factor(const scenes::Image& now, const scenes::Image& reference);

}  // namespace sideray::lab
