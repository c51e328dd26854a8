// Converts linear radiance to what a host works in. Any thread may call it.
#pragma once

#include <sideray/sideray.h>

#include <algorithm>

#include "elementary/functions.h"

namespace sideray::rt {

// Values below 0 count as 0. sRGB and gamma go on above 1 as below.
inline float encode_radiance(float x, sideray_radiance_space space, float scale) {
  const float scaled = std::max(x, 0.0f) * scale;
  if (space == SIDERAY_SPACE_GAMMA22) return elementary::pow(scaled, 1.0f / 2.2f);
  if (space == SIDERAY_SPACE_SRGB)
    return scaled <= 0.0031308f ? 12.92f * scaled : 1.055f * elementary::pow(scaled, 1.0f / 2.4f) - 0.055f;
  return scaled;
}

}  // namespace sideray::rt
