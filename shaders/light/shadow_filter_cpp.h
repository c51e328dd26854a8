// The shadow denoiser's arithmetic as C++ on GLM types, in namespace sideray::shading. Include this, never
// shadow_filter.h itself.
#pragma once

#include "shaders/shading/shading_cpp.h"

namespace sideray::shading {

#define SR_FN inline __attribute__((always_inline))
#include "shaders/light/shadow_filter.h"
#undef SR_FN

}  // namespace sideray::shading
