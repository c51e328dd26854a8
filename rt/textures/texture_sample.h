// Samples textures as the rasterizer does: wrap modes, nearest, bilinear, trilinear, sRGB decoding. Depends only on
// model/. Any thread may call it.
#pragma once

#include <glm/glm.hpp>

#include "model/snapshot.h"
#include "rt/textures/alpha_grid.h"

namespace sideray::rt {

// Returns a colour in linear light. `uv` is the mesh's; this function applies the slot's map. `level` is the mip level
// (log2 of texels per pixel) and matters only for SIDERAY_TRILINEAR. A non-finite coordinate reads as 0.
glm::vec4 sample(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv, float level);

// Returns the alpha of sample(), with the same bits, without computing the colour.
float sample_alpha(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv, float level);

// Returns the linear values of the 256 sRGB codes.
const float* srgb_decode_table();

// Bounds sample_alpha() at level 0 by the texture's alpha grid.
struct AlphaRange {
  float least, most;
};
AlphaRange alpha_range(const AlphaGrid& grid, const sideray_texture_slot& slot, glm::vec2 uv);

}  // namespace sideray::rt
