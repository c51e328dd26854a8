// The mip level that a ray cone asks for where it meets a triangle. Knows model/ alone. Any thread.
#pragma once

#include <glm/glm.hpp>

#include "model/snapshot.h"

namespace sideray::rt {

// A cone cuts a plane in an ellipse (Akenine-Moeller et al., Improved Shader and Texture Level of Detail Using Ray
// Cones, JCGT 2021). Its two diameters, in steps of the weights of the triangle's second and third vertex.
struct TextureFootprint {
  glm::vec2 along, across;
};

// Edges from the first vertex to the second and third; `direction` is unit, `width` the cone's where it hits.
TextureFootprint texture_footprint(glm::vec3 edge1, glm::vec3 edge2, glm::vec3 direction, float width);

// log2 of the texels that the longer diameter spans, as OpenGL measures derivatives; `edge` in uv before the slot's
// map.
float texture_level(const TextureFootprint& footprint, glm::vec2 edge1, glm::vec2 edge2,
                    const sideray_texture_slot& slot, const model::Texture& texture);

}  // namespace sideray::rt
