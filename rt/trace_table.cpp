#include "rt/trace_table.h"

#include <utility>

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
                        .mirrored = instance.mirrored,
                        .culls = material.cull_back,
                        .discards = material.discards || vertex_alpha,
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

bool alpha_discards(const model::Snapshot& snapshot, const TraceInstance& instance, uint32_t primitive, float u,
                    float v) {
  const sideray_material_desc& desc = instance.material->desc;
  const model::Mesh& mesh = *instance.mesh;
  const glm::uvec3 t = instance.triangles[primitive];
  const float w = 1.0f - u - v;
  float alpha = desc.base_color[3] * (w * mesh.colors[t.x].w + u * mesh.colors[t.y].w + v * mesh.colors[t.z].w);
  const sideray_texture_slot& slot = desc.base_color_texture;
  if (slot.texture != 0) {
    const std::vector<glm::vec2>& uv = slot.uv_set == 0 ? mesh.uv0 : mesh.uv1;
    alpha *= sample_alpha(*snapshot.textures[slot.texture - 1], slot, w * uv[t.x] + u * uv[t.y] + v * uv[t.z]);
  }
  return alpha < (desc.alpha_mode == SIDERAY_MASK ? desc.alpha_cutoff : 1.0f / 255.0f);
}

}  // namespace sideray::rt
