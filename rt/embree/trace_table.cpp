#include "rt/embree/trace_table.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace sideray::rt {
namespace {

// Returns the grid of the base colour's texture if only its alpha varies over the surface, else null. Makes it if the
// table has none yet.
const AlphaGrid* grid_of(const model::Snapshot& snapshot, const model::Mesh& mesh, const model::Material& material,
                         TraceTable& table) {
  const uint32_t texture = material.desc.base_color_texture.texture;
  if (!material.discards || texture == 0 || mesh.has_colors) return nullptr;
  std::shared_ptr<const AlphaGrid>& grid = table.grids[texture - 1];
  if (!grid) grid = std::make_shared<const AlphaGrid>(snapshot.textures[texture - 1]->levels[0]);
  return grid.get();
}

void take_over_grids(const model::Snapshot& snapshot, const TraceTable& before, TraceTable& table) {
  table.grids.resize(snapshot.textures.size());
  std::unordered_map<const model::Texture*, size_t> known;
  for (size_t i = 0; i < before.grids.size(); ++i)
    if (before.grids[i]) known.emplace(before.snapshot->textures[i].get(), i);
  if (known.empty()) return;
  for (size_t i = 0; i < table.grids.size(); ++i)
    if (const auto found = known.find(snapshot.textures[i].get()); found != known.end())
      table.grids[i] = before.grids[found->second];
}

}  // namespace

TraceTable build_trace_table(std::shared_ptr<const model::Snapshot> snapshot, const TraceTable& before) {
  TraceTable table;
  take_over_grids(*snapshot, before, table);
  table.instances.reserve(snapshot->instances.size());
  for (const model::Instance& instance : snapshot->instances) {
    const model::Mesh& mesh = *snapshot->meshes[instance.mesh];
    const model::Material& material = snapshot->materials[instance.material];
    // Vertex alpha belongs to the mesh, so the material's own flag does not include it.
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
                        .material = &material,
                        .alpha = instance.sprites == 0 ? grid_of(*snapshot, mesh, material, table) : nullptr};
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

}  // namespace sideray::rt
