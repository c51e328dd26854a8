// Corrects the JSON of a glTF file before tinygltf reads it. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

namespace sideray::scenes::gltf {

// Each function changes something that exporters write and tinygltf refuses, and returns whether it changed anything.
// Removes lists that are null, which means the same as no list.
bool drop_nulls(nlohmann::json& root);
// Changes whole numbers that are written as 3.0, which is the same number in JSON.
bool mend_numbers(nlohmann::json& root);
// Removes the attributes of primitives without vertices or indices, so that they are skipped.
bool hide_empty_primitives(nlohmann::json& root);
// Gives spot lights without angles the default ones.
bool mend_spots(nlohmann::json& root);
// Gives channels with pointers the node -1: tinygltf drops channels without a node.
bool mend_targets(nlohmann::json& root);
// Replaces cameras of an unknown type, or without the values of their type, by valid ones. Returns their indices.
std::set<size_t> hide_broken_cameras(nlohmann::json& root);
// Points buffer views with EXT_meshopt_compression at their compressed bytes, so that the checks and the loading of
// views need no exception: the place for decoded bytes that they name need not exist. Throws Error.
bool point_at_compressed(nlohmann::json& root, const std::string& path);
// Moves `indices` of Draco primitives into their extensions: tinygltf refuses such accessors, which have no data.
bool hide_draco_indices(nlohmann::json& root, const std::string& path);

}  // namespace sideray::scenes::gltf
