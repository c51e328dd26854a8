// Checks a caller's mesh and makes the dense form that readers rely on. Any thread may call it.
#pragma once

#include <memory>
#include <vector>

#include "model/snapshot.h"

namespace sideray::model {

// Remembers what a mesh was made of and its dense form does not say.
struct MeshForm {
  uint32_t vertex_count = 0;        // as given by the caller
  bool has_normals = false;         // otherwise flat: every corner of a triangle is a vertex
  std::vector<glm::uvec3> corners;  // flat: given vertices of each triangle
};

// Throws Failure (INVALID_ARGUMENT). `dropped`, where not null, receives the number of triangles left out.
std::shared_ptr<const Mesh> build_mesh(const sideray_mesh_desc& desc, uint32_t* dropped, MeshForm& form);
// Builds the same triangles over other vertices. Throws Failure (INVALID_ARGUMENT).
std::shared_ptr<const Mesh> build_moved_mesh(const Mesh& mesh, const MeshForm& form, const sideray_mesh_desc& desc);

// Returns whether the triangles of both have the same corners, wherever those are.
bool same_triangles(const Mesh& a, const Mesh& b);

// Returns the mesh `index` of `now` as it was in the snapshot before, where it has the same triangles over other
// vertices; or null.
const Mesh* shaped_before(const Snapshot& now, uint32_t index, const Snapshot& before);

// Returns the instance `index` of `now` in the snapshot before, where it has the same mesh and stood elsewhere, or
// anywhere where the mesh was `shaped` otherwise; or null.
const Instance* elsewhere_before(const Snapshot& now, uint32_t index, const Snapshot& before, bool shaped);

}  // namespace sideray::model
