// Computes the mip level that a ray cone requires where it hits a triangle. Knows model/ alone. Any thread may call it.
#pragma once

#include <glm/glm.hpp>

#include "model/snapshot.h"

namespace sideray::rt {

// Holds the ellipse in which a cone cuts a plane (Akenine-Moeller et al., Improved Shader and Texture Level of Detail
// Using Ray Cones, JCGT 2021): its two diameters, in steps of the weights of the triangle's second and third vertex.
struct TextureFootprint {
  glm::vec2 along, across;
};

// Takes the edges from the first vertex to the second and third; `direction` is unit, `width` the cone's where it hits.
TextureFootprint texture_footprint(glm::vec3 edge1, glm::vec3 edge2, glm::vec3 direction, float width);

// Returns log2 of the texels that the longer diameter spans, as OpenGL measures derivatives; `edge` in uv before the
// slot's map.
float texture_level(const TextureFootprint& footprint, glm::vec2 edge1, glm::vec2 edge2,
                    const sideray_texture_slot& slot, const model::Texture& texture);

}  // namespace sideray::rt
