// Gathers the data of an instance that recomputing a hit reads, so that it costs one look-up. It is built with the
// acceleration structures and immutable afterwards; any thread may read it.
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
  uint32_t sprites;  // as in model::Instance
  bool mirrored;
  bool culls;     // shows only its front
  bool discards;  // has texels or vertices with too little alpha
  const model::Mesh* mesh;
  const model::Material* material;
  // The alpha grid of the base colour's texture if only that decides what the instance discards; otherwise null.
  const AlphaGrid* alpha;
};

// Is indexed like Snapshot::instances. Points into the snapshot and keeps it alive.
struct TraceTable {
  static constexpr uint8_t trait_culls = 1, trait_discards = 2;

  std::shared_ptr<const model::Snapshot> snapshot;
  std::vector<TraceInstance> instances;
  std::vector<uint8_t> traits;  // decide early whether a hit counts; small enough to stay in the cache
  uint8_t all_traits = 0;       // union of the instances' traits
  std::vector<std::shared_ptr<const AlphaGrid>> grids;  // like Snapshot::textures; null where none is needed
};

// Builds the table of a snapshot, and reuses the grids of textures that the previous table has too.
TraceTable build_trace_table(std::shared_ptr<const model::Snapshot> snapshot, const TraceTable& before = {});

}  // namespace sideray::rt
