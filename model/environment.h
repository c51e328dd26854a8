// Builds the images that image-based lighting reads from one lat-long picture. Any thread may call it.
#pragma once

#include <algorithm>
#include <memory>

#include "elementary/functions.h"
#include "model/snapshot.h"

namespace sideray::model {

// `rgb`: width * height triples, top row first (+Y), centre = -Z, u grows toward +X; null gives a black environment.
std::shared_ptr<const Environment> build_environment(uint32_t width, uint32_t height, const float* rgb, float scale,
                                                     float rotation_deg);

// Converts linear radiance to a host's space. Values below 0 count as 0; sRGB and gamma continue above 1.
inline float encode_radiance(float x, sideray_radiance_space space, float scale) {
  const float scaled = std::max(x, 0.0f) * scale;
  if (space == SIDERAY_SPACE_GAMMA22) return elementary::pow(scaled, 1.0f / 2.2f);
  if (space == SIDERAY_SPACE_SRGB)
    return scaled <= 0.0031308f ? 12.92f * scaled : 1.055f * elementary::pow(scaled, 1.0f / 2.4f) - 0.055f;
  return scaled;
}

// Returns the environment with radiance encoded for a space.
std::shared_ptr<const Environment> encoded_environment(const Environment& linear, sideray_radiance_space space);

}  // namespace sideray::model
