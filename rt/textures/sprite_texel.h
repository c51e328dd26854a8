// Finds the flip-book texel and the colour where a ray hits a sprite's quad (rt/poses/particle_quads.h). Any thread may
// call it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "model/snapshot.h"
#include "rt/base/ray.h"

namespace sideray::rt {

// Returns the particle system's texture, or null if it has none.
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

// Returns whether the alpha there is too low (sr_sprite_absent); `hit` is on an instance of quads.
bool sprite_discards(const model::Snapshot& snapshot, const Hit& hit);

}  // namespace sideray::rt
