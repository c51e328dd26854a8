// The JSON of a glTF file, refused where it is too large or not JSON. Any thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <span>
#include <string>

#include "scenes/base/budget.h"

namespace sideray::scenes::gltf {

// Without line ends and the last full stop, and of a length that an error message can hold.
std::string one_line(std::string text);

// Takes what its values will need. Throws Error, which names `path`.
nlohmann::json parse_json(std::span<const uint8_t> text, const std::string& path, Budget& budget);

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

}  // namespace sideray::scenes::gltf
