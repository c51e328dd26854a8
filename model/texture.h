// Copies an image and builds its mip levels, for both the rasterizer and the tracer. Any thread may call it.
#pragma once

#include <memory>

#include "model/snapshot.h"

namespace sideray::model {

// Returns the table from 8-bit sRGB codes to linear light.
const float (&srgb_to_linear_table())[256];

// Throws Failure (INVALID_ARGUMENT).
std::shared_ptr<const Texture> build_texture(uint32_t width, uint32_t height, sideray_texel_format format,
                                             const void* texels);

}  // namespace sideray::model
