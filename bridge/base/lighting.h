// Limits how references sample light, for options and for hosts. Any thread.
#pragma once

#include <cstdint>

#include "model/failure.h"

namespace sideray::bridge {

inline constexpr uint32_t most_light_samples = 1u << 20, most_bounces = 1u << 16;

// Throws Failure (INVALID_ARGUMENT) where samples or bounces are out of range.
inline void check_lighting(uint32_t samples, uint32_t bounces) {
  if (samples < 1 || samples > most_light_samples)
    fail(SIDERAY_INVALID_ARGUMENT, "light_samples {}: give 1 to {}", samples, most_light_samples);
  if (bounces > most_bounces)
    fail(SIDERAY_INVALID_ARGUMENT, "bounces {}: give 1 to {}, or 0 for unlimited", bounces, most_bounces);
}

}  // namespace sideray::bridge
