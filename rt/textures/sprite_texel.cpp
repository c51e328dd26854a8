#include "rt/textures/sprite_texel.h"

#include "model/particles.h"
#include "rt/textures/texture_sample.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {

const model::Texture* sprite_texture(const model::Snapshot& snapshot, const sideray_particles_desc& d) {
  return d.texture ? snapshot.textures[d.texture - 1].get() : nullptr;
}

QuadPlace quad_place(const model::Snapshot& snapshot, const Hit& hit) {
  const model::Instance& instance = snapshot.instances[hit.instance];
  const model::ParticleSystem& system = snapshot.particles[instance.sprites - 1];
  const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
  const glm::uvec3 t = mesh.triangles[hit.primitive];
  QuadPlace place{system.desc, system.sprites[hit.primitive / 2], mesh, t.x, mesh.colors[t.x]};
  const model::Texture* texture = sprite_texture(snapshot, system.desc);
  if (!texture) return place;
  const glm::vec2 corner = mesh.uv0[t.x] * (1.0f - hit.u - hit.v) + mesh.uv0[t.y] * hit.u + mesh.uv0[t.z] * hit.v;
  const model::FlipBook book = model::flip_book(system.desc, texture);
  const float level = mesh.uv1[t.x].x;
  const uint32_t columns = system.desc.columns;
  const glm::vec2 cell(static_cast<float>(place.sprite.cell % columns),
                       static_cast<float>(place.sprite.cell / columns));
  const glm::vec2 cells(static_cast<float>(columns), static_cast<float>(system.desc.rows));
  const glm::vec2 uv = shading::sr_sprite_place(corner, cell, cells, book.cell_texels, level);
  place.color *= sample(*texture, model::flip_book_slot(), uv, level);
  return place;
}

bool sprite_discards(const model::Snapshot& snapshot, const Hit& hit) {
  const QuadPlace place = quad_place(snapshot, hit);
  return shading::sr_sprite_absent(place.color.w, static_cast<int>(place.desc.blend_mode));
}

}  // namespace sideray::rt
