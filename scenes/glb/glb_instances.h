// Finds which objects of a content a .glb file stores as instances of one node (EXT_mesh_gpu_instancing), and the
// attributes that such a node has. Used by the writer and the reader of files; any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::scenes {

constexpr const char* instancing_extension = "EXT_mesh_gpu_instancing";
// Custom attributes of each instance: its matrix in doubles, because the floats of a rotation are too coarse (accessors
// hold no doubles: a row of four is 16 unsigned shorts, the lowest bits first), then values that differ between
// instances.
constexpr const char* matrix_row_attributes[3] = {"_MATRIX_ROW_0", "_MATRIX_ROW_1", "_MATRIX_ROW_2"};
constexpr const char* wind_phase_attribute = "_WIND_PHASE";
constexpr const char* object_index_attribute = "_OBJECT_INDEX";

// Fewer instances take less JSON as separate nodes.
constexpr size_t fewest_instances = 8;

struct InstanceFloats {
  const float *translation = nullptr, *rotation = nullptr, *scale = nullptr;  // 3, 4 (x, y, z, w) and 3 floats; null if
                                                                              // there is none
};
// Returns translation times rotation times scale, bit for bit as the reader computes it.
glm::dmat4 instance_transform(const InstanceFloats& floats);

// Holds the objects of one node of the file: one object, or several instances. Ascending indices into Content::objects.
using ObjectGroup = std::vector<uint32_t>;
// Returns every object once, groups in the order of their first objects. Instances share name, mesh, material and wind,
// are not animated, and have transforms that are translation, rotation and scale.
std::vector<ObjectGroup> group_objects(const Content& content);

struct InstanceAttributes {
  std::vector<float> translations, rotations, scales, wind_phases, object_indices;
  std::vector<uint16_t> matrix_rows[3];  // each empty if the floats give that row of every matrix to the last bit
};
InstanceAttributes instance_attributes(const Content& content, const ObjectGroup& group);

}  // namespace sideray::scenes
