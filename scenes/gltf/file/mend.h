// Changes to the JSON of a glTF file before tinygltf reads it. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

namespace sideray::scenes::gltf {

// Each changes what exporters write and tinygltf refuses, and returns whether there was any.
// Lists that are null, which says as much as that there are none.
bool drop_nulls(nlohmann::json& root);
// Whole numbers that are written as 3.0: JSON makes no difference, tinygltf does.
bool mend_numbers(nlohmann::json& root);
// Primitives that have no vertices or no indices at all lose their attributes, and so are not looked at.
bool hide_empty_primitives(nlohmann::json& root);
// Spot lights without angles have the default ones.
bool mend_spots(nlohmann::json& root);
// Channels that pointers target have no node, which tinygltf would drop them for: they name node -1.
bool mend_targets(nlohmann::json& root);
// Cameras of an unknown type, or without what their type wants, become others; returns which.
std::set<size_t> hide_broken_cameras(nlohmann::json& root);
// Buffer views with EXT_meshopt_compression name a place for decoded bytes that need not exist. They then name their
// compressed bytes instead, so that what checks and loads views sees nothing special. Throws Error.
bool point_at_compressed(nlohmann::json& root, const std::string& path);
// tinygltf wants data behind every accessor of indices, and Draco's has none: the extension keeps their number.
bool hide_draco_indices(nlohmann::json& root, const std::string& path);

}  // namespace sideray::scenes::gltf
