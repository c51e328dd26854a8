// Holds morph targets: shapes that a mesh is blended with. Any thread.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::scenes {

// What a target adds to each vertex at weight 1: 3 numbers for positions, normals and tangents, 2 for uvs, 4 for
// colours; empty if it changes nothing.
struct MorphTarget {
  std::vector<float> positions, normals, tangents, uv0, uv1, colors;
};
using MorphTargets = std::vector<MorphTarget>;

// A mesh of a single node, blended at each time.
struct MorphedMesh {
  uint32_t mesh = 0;        // of Content::meshes
  uint32_t node = 0;        // index in the rig: the node with the weights
  bool is_skinned = false;  // a skin is applied after blending
  Mesh base;                // attributes at weight 0; no indices
  std::shared_ptr<const MorphTargets> targets;
  std::vector<double> weights;  // for no animation; one for each target
};

// Writes base + sum(weight * target) to the attributes of `mesh`, which has the base's vertices. Normals and tangents
// get unit length, colours are clamped to 0..1, and vertices without a finite position stay at the base.
void blend(const Mesh& base, const MorphTargets& targets, std::span<const double> weights, Mesh& mesh);

// Returns positions at unusual weights: a triangle that has area at any weights has area there.
std::vector<float> generic_positions(const MorphedMesh& morphed);

}  // namespace sideray::scenes
