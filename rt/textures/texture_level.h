// Computes the mip level for a ray cone's footprint on a triangle. Depends only on model/. Any thread may call it.
#pragma once

#include <glm/glm.hpp>

#include "model/snapshot.h"
#include "rt/base/ray.h"

namespace sideray::rt {

// Holds two diameters of the ellipse in which a cone cuts a plane (Akenine-Moeller et al., Improved Shader and Texture Level of Detail
// Using Ray Cones, JCGT 2021), as differences of the second and third vertex's weights: the longest and the shortest, or those that a
// view's pixels are apart.
struct TextureFootprint {
  glm::vec2 along, across;
};

// `edge1` and `edge2` lead from the first vertex to the second and third; `direction` is unit, `width` the cone's at
// the hit. `steps`: of the view whose pixel the ray goes through, or null.
TextureFootprint texture_footprint(glm::vec3 edge1, glm::vec3 edge2, glm::vec3 direction, float width,
                                   const PixelSteps* steps = nullptr);

// Returns log2 of the number of texels along the longer of both, as OpenGL measures derivatives; edges are in uv before
// the slot's map.
float texture_level(const TextureFootprint& footprint, glm::vec2 edge1, glm::vec2 edge2,
                    const sideray_texture_slot& slot, const model::Texture& texture);

}  // namespace sideray::rt
