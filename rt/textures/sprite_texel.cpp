#include "rt/textures/sprite_texel.h"

#include "model/particles.h"
#include "rt/textures/texture_sample.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {

const model::Texture* sprite_texture(const model::Snapshot& snapshot, const sideray_particles_desc& d) {
  return d.texture ? snapshot.textures[d.texture - 1].get() : nullptr;
}

namespace {

// Refers to what a hit on a quad depends on.
struct Quad {
  const model::ParticleSystem& system;
  const model::Mesh& mesh;
  const model::Sprite& sprite;
  glm::uvec3 corners;
  const model::Texture* texture;  // null: none

  Quad(const model::Snapshot& snapshot, const Hit& hit)
      : system(snapshot.particles[snapshot.instances[hit.instance].sprites - 1]),
        mesh(*snapshot.meshes[snapshot.instances[hit.instance].mesh]),
        sprite(system.sprites[hit.primitive / 2]),
        corners(mesh.triangles[hit.primitive]),
        texture(sprite_texture(snapshot, system.desc)) {}

  float level() const { return mesh.uv1[corners.x].x; }
  glm::vec2 texel_place(const Hit& hit) const {
    const glm::vec2 corner =
        mesh.uv0[corners.x] * (1.0f - hit.u - hit.v) + mesh.uv0[corners.y] * hit.u + mesh.uv0[corners.z] * hit.v;
    const uint32_t columns = system.desc.columns;
    const glm::vec2 cell(static_cast<float>(sprite.cell % columns), static_cast<float>(sprite.cell / columns));
    const glm::vec2 cells(static_cast<float>(columns), static_cast<float>(system.desc.rows));
    return shading::sr_sprite_place(corner, cell, cells, model::flip_book(system.desc, texture).cell_texels, level());
  }
};

}  // namespace

QuadPlace quad_place(const model::Snapshot& snapshot, const Hit& hit) {
  const Quad quad(snapshot, hit);
  QuadPlace place{quad.system.desc, quad.sprite, quad.mesh, quad.corners.x, quad.mesh.colors[quad.corners.x]};
  if (quad.texture)
    place.color *= sample(*quad.texture, model::flip_book_slot(), quad.texel_place(hit), quad.level());
  return place;
}

bool sprite_discards(const model::Snapshot& snapshot, const Hit& hit) {
  const Quad quad(snapshot, hit);
  float alpha = quad.mesh.colors[quad.corners.x].w;
  if (quad.texture)
    alpha *= sample_alpha(*quad.texture, model::flip_book_slot(), quad.texel_place(hit), quad.level());
  return shading::sr_sprite_absent(alpha, static_cast<int>(quad.system.desc.blend_mode));
}

}  // namespace sideray::rt
