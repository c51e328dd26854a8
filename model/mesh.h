// Checks a caller's mesh and converts it to the dense form that readers expect. Any thread may call it.
#pragma once

#include <memory>
#include <vector>

#include "model/snapshot.h"

namespace sideray::model {

// Remembers properties of the given mesh that its dense form lacks.
struct MeshForm {
  uint32_t vertex_count = 0;        // as given by the caller
  bool has_normals = false;         // otherwise flat: every corner of a triangle is a vertex
  std::vector<glm::uvec3> corners;  // flat: given vertices of each triangle
};

// Throws Failure (INVALID_ARGUMENT). `dropped`, if not null, receives the number of omitted triangles.
std::shared_ptr<const Mesh> build_mesh(const sideray_mesh_desc& desc, uint32_t* dropped, MeshForm& form);
// Builds the same triangles with other vertices. Throws Failure (INVALID_ARGUMENT).
std::shared_ptr<const Mesh> build_moved_mesh(const Mesh& mesh, const MeshForm& form, const sideray_mesh_desc& desc);

// Returns whether the triangles of both have the same vertex indices, whatever their positions.
bool same_triangles(const Mesh& a, const Mesh& b);

// Returns mesh `index` of `now` in the snapshot before, if it has the same triangles but other vertices there;
// otherwise null.
const Mesh* shaped_before(const Snapshot& now, uint32_t index, const Snapshot& before);

// Returns instance `index` of `now` in the snapshot before, if it has the same mesh there and moved, or if the mesh was
// `shaped` differently; otherwise null.
const Instance* elsewhere_before(const Snapshot& now, uint32_t index, const Snapshot& before, bool shaped);

}  // namespace sideray::model
