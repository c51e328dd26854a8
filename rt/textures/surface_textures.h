// Reads a material's textures at a point of a triangle: the look-ups that it needs are prepared once, then made. Knows
// model/ and the shading model's terms. Any thread may call it.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "model/material_slots.h"
#include "model/snapshot.h"
#include "rt/textures/texture_level.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {

struct TextureRead {
  const model::Texture* texture;
  const sideray_texture_slot* place;
  uint32_t slot;  // index into model::material_slots
  // The material's earlier read whose value this one reuses: images often pack several maps (occlusion, roughness,
  // metal). Its own number if there is none.
  uint32_t same_as;
};

// Lists the material's reads, in the order of model::material_slots; without those that only scale a factor of 0. They
// point into `snapshot`.
std::vector<TextureRead> texture_reads(const model::Snapshot& snapshot, const sideray_material_desc& material);

// Says where on a triangle look-ups are made, and how much of it they are to cover.
struct TexturePlace {
  const model::Mesh& mesh;
  glm::uvec3 triangle;
  glm::vec3 weights;
  TextureFootprint footprint;
};

struct TextureValues {
  shading::SrTexels texels;
  // These are in tangent space, z along the normal; (0, 0, 1) where there is no map.
  glm::vec3 normal, coat_normal;
};

inline constexpr shading::SrTexels no_texels{glm::vec4(1.0f),
                                             glm::vec3(1.0f),
                                             1.0f,
                                             1.0f,
                                             1.0f,
                                             1.0f,
                                             1.0f,
                                             1.0f,
                                             glm::vec3(1.0f),
                                             1.0f,
                                             1.0f,
                                             glm::vec3(1.0f),
                                             1.0f,
                                             1.0f,
                                             glm::vec3(1.0f),
                                             1.0f,
                                             1.0f,
                                             1.0f,
                                             0.0f,
                                             1.0f};
inline constexpr TextureValues no_textures{no_texels, glm::vec3(0, 0, 1), glm::vec3(0, 0, 1)};

TextureValues read_textures(std::span<const TextureRead> reads, const TexturePlace& place, float occlusion_strength);

}  // namespace sideray::rt
