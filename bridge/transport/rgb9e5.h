// Radiance in 32 bits a texel: GL_RGB9_E5, as EXT_texture_shared_exponent defines it. Any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

namespace sideray::bridge {

// Packs texels of four halfs, none of them negative or not a number, of which the first three count. What is above the
// format's largest value, 65408, becomes that. A component is off by at most half a step, 2^-9 of the largest one's
// power of two.
void pack_rgb9e5(const uint16_t* halfs, uint32_t* packed, size_t texels);

glm::vec3 unpack_rgb9e5(uint32_t packed);

}  // namespace sideray::bridge
