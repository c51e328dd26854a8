// Checks particle systems and their sprites, and places them in a snapshot. Any thread may call it.
#pragma once

#include <cstddef>

#include "model/snapshot.h"

namespace sideray::model {

// Throw Failure (INVALID_ARGUMENT) that names the fault. The scene checks whether the texture exists.
void check_particles(const sideray_particles_desc& desc);
void check_sprites(const sideray_sprite* sprites, size_t count);

// Says how a texture's cells are read; null = white.
struct FlipBook {
  glm::vec2 cell_texels;
  float last_level;  // mip level up to which no texel spans two cells
};
FlipBook flip_book(const sideray_particles_desc& desc, const Texture* texture);
sideray_texture_slot flip_book_slot();

Sprite local_sprite(const sideray_sprite& sprite, const sideray_particles_desc& desc, glm::dvec3 origin);

}  // namespace sideray::model
