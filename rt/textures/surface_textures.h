// Samples a material's textures at a point of a triangle; the list of look-ups is made once per material. Depends on
// model/ and the shading model's structs. Any thread may call it.
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
  // Index of an earlier read of the material whose value this one reuses, because images often pack several maps
  // (occlusion, roughness, metal). Its own index if there is none.
  uint32_t same_as;
};

// Lists the material's reads, in the order of model::material_slots, without those that would scale a factor of 0. They
// point into `snapshot`.
std::vector<TextureRead> texture_reads(const model::Snapshot& snapshot, const sideray_material_desc& material);

// Says where on a triangle textures are sampled, and the footprint.
struct TexturePlace {
  const model::Mesh& mesh;
  glm::uvec3 triangle;
  glm::vec3 weights;
  TextureFootprint footprint;
};

struct TextureValues {
  shading::SrTexels texels;
  // In tangent space, z along the normal; (0, 0, 1) without a map.
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
