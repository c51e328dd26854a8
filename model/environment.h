// Builds the images that image-based lighting reads from one lat-long picture. Any thread may call it.
#pragma once

#include <memory>

#include "model/snapshot.h"

namespace sideray::model {

// `rgb`: width * height triples, top row first (+Y), centre = -Z, u grows toward +X; null gives a black environment.
std::shared_ptr<const Environment> build_environment(uint32_t width, uint32_t height, const float* rgb, float scale,
                                                     float rotation_deg);

}  // namespace sideray::model
