// Finds what a ray sees on the quad of a sprite (rt/poses/particle_quads.h): its place in the flip-book, and its
// colour. Any thread may call it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "model/snapshot.h"
#include "rt/base/ray.h"

namespace sideray::rt {

// Returns null where the system has no texture.
const model::Texture* sprite_texture(const model::Snapshot& snapshot, const sideray_particles_desc& d);

struct QuadPlace {
  const sideray_particles_desc& desc;
  const model::Sprite& sprite;
  const model::Mesh& mesh;
  uint32_t vertex;  // the first of four
  glm::vec4 color;  // texel times colour
};

// `hit` is on an instance of quads.
QuadPlace quad_place(const model::Snapshot& snapshot, const Hit& hit);

// Returns whether too little alpha is there (sr_sprite_absent); `hit` is on an instance of quads.
bool sprite_discards(const model::Snapshot& snapshot, const Hit& hit);

}  // namespace sideray::rt
