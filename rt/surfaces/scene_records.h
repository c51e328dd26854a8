// Makes the records of a snapshot that surface kernels read. Immutable once made; any thread may read them.
#pragma once

#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/surfaces/surface_records.h"
#include "rt/textures/surface_textures.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {

// Points into the snapshot, which the owner keeps alive.
struct SceneRecords {
  std::vector<InstanceRecord> instances;  // of the snapshot, followed by those of its lines and points
  std::vector<MaterialRecord> materials;
  std::vector<ReadRecord> reads;
  std::vector<OutputRecord> outputs;
  std::vector<FixedRecord> fixed;  // in a scene of the fixed function; else empty
  FixedModelTerms model{};
  std::vector<LevelRecord> levels;
  bool sprites = false;  // some instance consists of sprites

  SurfaceTables tables() const;
};

// `textures` are the reads of each material; `fixed` is empty except in scenes of the fixed function.
SceneRecords make_records(const model::Snapshot& snapshot, std::span<const shading::SrMaterial> materials,
                          std::span<const shading::SrFixedMaterial> fixed,
                          std::span<const std::vector<TextureRead>> textures);

}  // namespace sideray::rt
