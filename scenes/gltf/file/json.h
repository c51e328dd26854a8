// Parses the JSON of a glTF file, which may be too large or damaged, and reads its values. Any thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "scenes/base/budget.h"

namespace sideray::scenes::gltf {

// Returns the text for an error message: shortened, without line ends and without a final full stop.
std::string one_line(std::string text);

// Parses the text, and takes the memory of its values from `budget`. Throws Error, which names `path`.
nlohmann::json parse_json(std::span<const uint8_t> text, const std::string& path, Budget& budget);

// Returns the list `key` of the root, empty where it is absent. Throws Error where its entries are not objects.
const nlohmann::json& objects(const nlohmann::json& root, const char* key, const std::string& path);

// Returns a whole number 0..2^31-1, since tinygltf keeps most of them in an int. Throws Error, which names `what`.
uint64_t whole(const nlohmann::json& object, const char* key, uint64_t fallback, const std::string& what);

}  // namespace sideray::scenes::gltf
