// Morph targets: shapes that a mesh is blended towards. Any thread.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::scenes {

// What one target adds to each vertex at weight 1: 3 numbers for positions, normals and tangents, 2 for uvs, 4 for
// colours; empty where it changes nothing.
struct MorphTarget {
  std::vector<float> positions, normals, tangents, uv0, uv1, colors;
};
using MorphTargets = std::vector<MorphTarget>;

// A mesh that belongs to one node alone and is blended anew at each time.
struct MorphedMesh {
  uint32_t mesh = 0;        // of Content::meshes
  uint32_t node = 0;        // of the rig: whose weights count
  bool is_skinned = false;  // a skin bends what is blended
  Mesh base;                // attributes at weight 0; no indices
  std::shared_ptr<const MorphTargets> targets;
  std::vector<double> weights;  // where no channel changes them; one for each target
};

// Puts base + sum(weight * target) into the attributes of `mesh`, which has the base's vertices. Normals and tangents
// get unit length, colours stay in 0..1 and a vertex that would lie nowhere stays at the base.
void blend(const Mesh& base, const MorphTargets& targets, std::span<const double> weights, Mesh& mesh);

// Returns positions at weights that no shape is made for: a triangle that has area at any weights has some there.
std::vector<float> generic_positions(const MorphedMesh& morphed);

}  // namespace sideray::scenes
