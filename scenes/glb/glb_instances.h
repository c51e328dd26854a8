// Groups the objects that a .glb file stores as instances of one node (EXT_mesh_gpu_instancing), and makes their
// attributes. The writer and the reader of files call it; any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::scenes {

constexpr const char* instancing_extension = "EXT_mesh_gpu_instancing";
// Custom attributes of each instance: its matrix in doubles, for which the floats of a rotation are too coarse, and its
// other own values. Accessors hold no doubles: a row of four is 16 unsigned shorts, the lowest bits first.
constexpr const char* matrix_row_attributes[3] = {"_MATRIX_ROW_0", "_MATRIX_ROW_1", "_MATRIX_ROW_2"};
constexpr const char* wind_phase_attribute = "_WIND_PHASE";
constexpr const char* object_index_attribute = "_OBJECT_INDEX";

// Fewer instances take less JSON as separate nodes.
constexpr size_t fewest_instances = 8;

struct InstanceFloats {
  const float *translation = nullptr, *rotation = nullptr, *scale = nullptr;  // 3, 4 (x, y, z, w), 3; null = none
};
// Returns translation times rotation times scale, with the same bits as in the reader.
glm::dmat4 instance_transform(const InstanceFloats& floats);

// The objects of one node of the file: a single one, or several instances. Ascending indices into Content::objects.
using ObjectGroup = std::vector<uint32_t>;
// Returns groups that hold every object once, in the order of their first objects. Instances of a group share name,
// mesh, material and wind, are not animated, and have placements of translation, rotation and scale.
std::vector<ObjectGroup> group_objects(const Content& content);

struct InstanceAttributes {
  std::vector<float> translations, rotations, scales, wind_phases, object_indices;
  std::vector<uint16_t> matrix_rows[3];  // empty for rows that the floats give exactly in every matrix
};
InstanceAttributes instance_attributes(const Content& content, const ObjectGroup& group);

}  // namespace sideray::scenes
