// Blends meshes towards morph targets. Any thread.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::scenes {

// Holds what one target adds to each vertex at weight 1: 3 numbers for positions, normals and tangents, 2 for uvs, 4
// for colours. An attribute that it does not change is empty.
struct MorphTarget {
  std::vector<float> positions, normals, tangents, uv0, uv1, colors;
};
using MorphTargets = std::vector<MorphTarget>;

// Holds a mesh of a single node, which is blended at each time.
struct MorphedMesh {
  uint32_t mesh = 0;        // of Content::meshes
  uint32_t node = 0;        // of the rig, whose weights apply
  bool is_skinned = false;  // a skin is applied to the blended mesh
  Mesh base;                // attributes at weight 0; no indices
  std::shared_ptr<const MorphTargets> targets;
  std::vector<double> weights;  // of each target, if no channel changes them
};

// Writes base + sum(weight * target) into the attributes of `mesh`, which has the base's vertices. Normals and tangents
// get unit length, colours stay in 0..1, and a vertex whose position is not finite or too far stays at the base.
void blend(const Mesh& base, const MorphTargets& targets, std::span<const double> weights, Mesh& mesh);

// Returns positions at arbitrary weights: there a triangle has an area unless it has none at all weights.
std::vector<float> generic_positions(const MorphedMesh& morphed);

}  // namespace sideray::scenes
