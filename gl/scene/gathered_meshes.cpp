#include "gl/scene/gathered_meshes.h"

#include <algorithm>

#include "gl/resources/raster_textures.h"

namespace sideray::gl {
namespace {

constexpr uint64_t most_gathered_bytes = uint64_t{64} << 20;
constexpr uint32_t sets_between_copies = 8;

uint64_t gathered_bytes(const model::Mesh& mesh) {
  return mesh.positions.size() * sizeof(glm::vec3) + mesh.triangles.size() * sizeof(glm::uvec3);
}

template <typename T>
void fill_gathered(const Functions& gl, uint32_t target, const Buffer& buffer, const std::vector<T>& values) {
  gl.BindBuffer(target, buffer.id());
  gl.BufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(), GL_STATIC_DRAW);
}

void point_gathered_at(const Functions& gl, uint32_t location, size_t stride, size_t offset) {
  gl.EnableVertexAttribArray(location);
  gl.VertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                         reinterpret_cast<const void*>(offset));
}

}  // namespace

void GatheredMeshes::set(std::span<const std::shared_ptr<const model::Mesh>> meshes, InstanceBuffer instances) {
  if (gl_.version < 43) return;
  ++sets_since_copy_;
  const auto known = static_cast<size_t>(
      std::count_if(meshes.begin(), meshes.end(), [&](const auto& mesh) { return holds(mesh.get()); }));
  const bool is_due = places_.empty() || sets_since_copy_ >= sets_between_copies;
  if (2 * known >= meshes.size() || !is_due) return;
  copy(meshes, instances);
}

void GatheredMeshes::copy(std::span<const std::shared_ptr<const model::Mesh>> meshes, InstanceBuffer instances) {
  sets_since_copy_ = 0;
  places_.clear();
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  uint64_t bytes = 0;
  for (const std::shared_ptr<const model::Mesh>& mesh : meshes) {
    if (holds(mesh.get()) || bytes + gathered_bytes(*mesh) > most_gathered_bytes) continue;
    bytes += gathered_bytes(*mesh);
    places_[mesh.get()] = {mesh, static_cast<uint32_t>(3 * triangles.size()), static_cast<uint32_t>(positions.size())};
    positions.insert(positions.end(), mesh->positions.begin(), mesh->positions.end());
    triangles.insert(triangles.end(), mesh->triangles.begin(), mesh->triangles.end());
  }
  positions_ = Buffer(gl_), indices_ = Buffer(gl_), commands_ = Buffer(gl_);
  vertex_array_ = VertexArray(gl_);
  gl_.BindVertexArray(vertex_array_.id());
  fill_gathered(gl_, GL_ARRAY_BUFFER, positions_, positions);
  point_gathered_at(gl_, 0, sizeof(glm::vec3), 0);
  fill_gathered(gl_, GL_ELEMENT_ARRAY_BUFFER, indices_, triangles);
  gl_.BindBuffer(GL_ARRAY_BUFFER, instances.buffer);
  for (uint32_t column = 0; column < 4; ++column) {
    point_gathered_at(gl_, 6 + column, instances.stride_bytes, column * sizeof(glm::vec3));
    gl_.VertexAttribDivisor(6 + column, 1);
  }
  gl_.BindVertexArray(0);
  check_allocation(gl_, "gathered meshes");
}

void GatheredMeshes::add(const model::Mesh* mesh, uint32_t first_instance, uint32_t instance_count) {
  const Place& place = places_.at(mesh);
  added_.push_back({static_cast<uint32_t>(3 * mesh->triangles.size()), instance_count, place.first_index,
                    place.base_vertex, first_instance});
}

void GatheredMeshes::draw() {
  if (added_.empty()) return;
  gl_.BindVertexArray(vertex_array_.id());
  gl_.BindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.id());
  gl_.BufferData(GL_DRAW_INDIRECT_BUFFER, static_cast<GLsizeiptr>(added_.size() * sizeof(Command)), added_.data(),
                 GL_STREAM_DRAW);
  gl_.MultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr, static_cast<GLsizei>(added_.size()), 0);
  gl_.BindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
  added_.clear();
}

}  // namespace sideray::gl
