// Changes the JSON of a glTF file before tinygltf reads it. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

namespace sideray::scenes::gltf {

// Each changes something that exporters write and tinygltf refuses, and returns whether there was any. drop_nulls()
// removes lists that are null, which means the same as no list.
bool drop_nulls(nlohmann::json& root);
// Rewrites whole numbers written as 3.0: JSON sees no difference, tinygltf does.
bool mend_numbers(nlohmann::json& root);
// Removes the attributes of primitives that have no vertices or no indices, so that they are not read.
bool hide_empty_primitives(nlohmann::json& root);
// Gives spot lights without angles the default angles.
bool mend_spots(nlohmann::json& root);
// Makes channels with pointers as targets name node -1, because tinygltf drops channels without a node.
bool mend_targets(nlohmann::json& root);
// Replaces cameras of an unknown type, or without the values that their type needs, and returns their indices.
std::set<size_t> hide_broken_cameras(nlohmann::json& root);
// Makes buffer views with EXT_meshopt_compression, whose place for decoded bytes need not exist, name their compressed
// bytes instead, so that code that checks and loads views needs no special case. Throws Error.
bool point_at_compressed(nlohmann::json& root, const std::string& path);
// Moves the index of a Draco primitive's index accessor into the extension, because tinygltf requires data behind
// accessors of indices, and Draco's has none.
bool hide_draco_indices(nlohmann::json& root, const std::string& path);

}  // namespace sideray::scenes::gltf
