// Keeps copies of meshes' positions in one vertex array, so that one call draws many of them: passes that need only
// positions have few triangles a draw, and drivers take longer for the draws than for the triangles. The context must
// be current.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "model/snapshot.h"

namespace sideray::gl {

// Describes the buffer of instances for shaders/surface/raster_surface.vert.glsl: local_from_object comes first.
struct InstanceBuffer {
  uint32_t buffer;
  uint32_t stride_bytes;
};

class GatheredMeshes {
 public:
  explicit GatheredMeshes(const Functions& gl) : gl_(gl) {}

  // Copies as many of these meshes as fit into its memory, from OpenGL 4.3 on. It copies only where more than half are
  // new, and at most every eighth call, so that meshes whose vertices move each frame cost little: it seldom holds
  // them. Throws Failure (OUT_OF_MEMORY).
  void set(std::span<const std::shared_ptr<const model::Mesh>> meshes, InstanceBuffer instances);
  bool holds(const model::Mesh* mesh) const { return places_.contains(mesh); }

  // Adds a draw of a mesh that is held; draw() then draws everything added, with the program in use.
  void add(const model::Mesh* mesh, uint32_t first_instance, uint32_t instance_count);
  void draw();

 private:
  struct Place {
    std::shared_ptr<const model::Mesh> mesh;
    uint32_t first_index, base_vertex;
  };
  // Has the fields that glMultiDrawElementsIndirect reads, in this order.
  struct Command {
    uint32_t index_count, instance_count, first_index, base_vertex, first_instance;
  };
  void copy(std::span<const std::shared_ptr<const model::Mesh>> meshes, InstanceBuffer instances);

  const Functions& gl_;
  std::map<const model::Mesh*, Place> places_;
  Buffer positions_, indices_, commands_;
  VertexArray vertex_array_;
  std::vector<Command> added_;
  uint32_t sets_since_copy_ = 0;
};

}  // namespace sideray::gl
