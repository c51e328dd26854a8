// What the recomputation of a hit reads of an instance, gathered in one place so that it costs one look-up. Built with
// the acceleration structures; immutable afterwards. Any thread.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"
#include "rt/textures/alpha_grid.h"

namespace sideray::rt {

struct alignas(64) TraceInstance {
  float columns[4][4];  // local_from_object; the fourth row is unused
  const glm::vec3* positions;
  const glm::uvec3* triangles;
  uint32_t surface_id;
  uint32_t sprites;  // as model::Instance
  bool mirrored;
  bool culls;     // shows only its front
  bool discards;  // has texels or vertices with too little alpha
  const model::Mesh* mesh;
  const model::Material* material;
  const AlphaGrid* alpha;  // of its base colour's texture, where that alone varies what it discards; or null
};

// Indexed like Snapshot::instances. Points into the snapshot, which it keeps.
struct TraceTable {
  static constexpr uint8_t trait_culls = 1, trait_discards = 2;

  std::shared_ptr<const model::Snapshot> snapshot;
  std::vector<TraceInstance> instances;
  std::vector<uint8_t> traits;  // what decides early whether a hit counts, small enough to stay in the cache
  uint8_t all_traits = 0;       // of any instance
  std::vector<std::shared_ptr<const AlphaGrid>> grids;  // like Snapshot::textures; null where none is needed
};

// Grids of textures that the table before has too are taken over.
TraceTable build_trace_table(std::shared_ptr<const model::Snapshot> snapshot, const TraceTable& before = {});

}  // namespace sideray::rt
