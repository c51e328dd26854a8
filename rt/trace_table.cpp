#include "rt/trace_table.h"

#include <algorithm>
#include <utility>

#include "rt/particle_quads.h"
#include "rt/recompute.h"
#include "rt/texture_level.h"
#include "rt/texture_sample.h"

namespace sideray::rt {

TraceTable build_trace_table(std::shared_ptr<const model::Snapshot> snapshot) {
  TraceTable table;
  table.instances.reserve(snapshot->instances.size());
  for (const model::Instance& instance : snapshot->instances) {
    const model::Mesh& mesh = *snapshot->meshes[instance.mesh];
    const model::Material& material = snapshot->materials[instance.material];
    // Vertex alpha belongs to the mesh, so the material's own flag may not know of it.
    const bool vertex_alpha = material.desc.alpha_mode != SIDERAY_OPAQUE && mesh.has_colors;
    TraceInstance entry{.columns = {},
                        .positions = mesh.positions.data(),
                        .triangles = mesh.triangles.data(),
                        .surface_id = instance.surface_id,
                        .sprites = instance.sprites,
                        .mirrored = instance.mirrored,
                        .culls = material.cull_back,
                        .discards = material.discards || (vertex_alpha && instance.sprites == 0),
                        .mesh = &mesh,
                        .material = &material};
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) entry.columns[c][r] = instance.local_from_object[c][r];
    table.instances.push_back(entry);
    const int traits = (entry.culls ? TraceTable::trait_culls : 0) | (entry.discards ? TraceTable::trait_discards : 0);
    table.traits.push_back(static_cast<uint8_t>(traits));
    table.all_traits |= table.traits.back();
  }
  table.snapshot = std::move(snapshot);
  return table;
}

namespace {

float base_color_level(const model::Texture& texture, const TraceInstance& instance, const std::vector<glm::vec2>& uv,
                       const Ray& ray, const Hit& hit, float width) {
  const sideray_texture_slot& slot = instance.material->desc.base_color_texture;
  if (width <= 0.0f || slot.filter != SIDERAY_TRILINEAR || texture.levels.size() == 1) return 0.0f;
  const glm::uvec3 t = instance.triangles[hit.primitive];
  const auto corner = [&](uint32_t vertex) {
    const LocalPosition p = local_position(instance, vertex);
    return glm::vec3(p.x[0], p.x[1], p.x[2]);
  };
  const glm::vec3 p0 = corner(t.x);
  const TextureFootprint footprint =
      texture_footprint(corner(t.y) - p0, corner(t.z) - p0, glm::normalize(ray.direction), width);
  return texture_level(footprint, uv[t.y] - uv[t.x], uv[t.z] - uv[t.x], slot, texture);
}

}  // namespace

bool alpha_discards(const model::Snapshot& snapshot, const TraceInstance& instance, const Ray& ray, const Hit& hit,
                    Cone cone) {
  if (instance.sprites != 0) return sprite_discards(snapshot, hit);
  const sideray_material_desc& desc = instance.material->desc;
  const model::Mesh& mesh = *instance.mesh;
  const glm::uvec3 t = instance.triangles[hit.primitive];
  const float w = 1.0f - hit.u - hit.v;
  float alpha = desc.base_color[3] * (w * mesh.colors[t.x].w + hit.u * mesh.colors[t.y].w + hit.v * mesh.colors[t.z].w);
  const sideray_texture_slot& slot = desc.base_color_texture;
  if (slot.texture != 0) {
    const model::Texture& texture = *snapshot.textures[slot.texture - 1];
    const std::vector<glm::vec2>& uv = slot.uv_set == 0 ? mesh.uv0 : mesh.uv1;
    const glm::vec2 at = w * uv[t.x] + hit.u * uv[t.y] + hit.v * uv[t.z];
    const float width = cone.width + cone.spread * static_cast<float>(hit.distance);
    const float level = base_color_level(texture, instance, uv, ray, hit, width);
    alpha *= level > 0.0f ? sample(texture, slot, at, level).w : sample_alpha(texture, slot, at);
  }
  return alpha < (desc.alpha_mode == SIDERAY_MASK ? desc.alpha_cutoff : 1.0f / 255.0f);
}

}  // namespace sideray::rt
