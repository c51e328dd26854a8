// Looks textures up as the rasterizer does: wraps, nearest, bilinear, trilinear, sRGB decode. Knows only model/. Any
// thread may call it.
#pragma once

#include <glm/glm.hpp>

#include "model/snapshot.h"
#include "rt/textures/alpha_grid.h"

namespace sideray::rt {

// Returns a colour, in linear light. `uv` is the mesh's; the slot's map is applied in here. `level` is the mip level
// (log2 of texels per pixel) and counts for SIDERAY_TRILINEAR only. A coordinate that is not finite reads as 0.
glm::vec4 sample(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv, float level);

// Returns the alpha of sample(texture, slot, uv, 0), bit for bit, without the colour.
float sample_alpha(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv);

// Returns what each of 256 codes of a colour is worth in linear light.
const float* srgb_decode_table();

// Bounds sample_alpha() by the texture's grid.
struct AlphaRange {
  float least, most;
};
AlphaRange alpha_range(const AlphaGrid& grid, const sideray_texture_slot& slot, glm::vec2 uv);

}  // namespace sideray::rt
