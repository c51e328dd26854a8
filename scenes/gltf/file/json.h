// Parses the JSON of a glTF file, with limits, and reads values from it. Any thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "scenes/base/budget.h"

namespace sideray::scenes::gltf {

// Returns the text without line ends and final full stop, cut to a length that fits into an error message.
std::string one_line(std::string text);

// Takes the memory of the values from the budget. Throws Error, which names `path`, if the text is too large or not
// JSON.
nlohmann::json parse_json(std::span<const uint8_t> text, const std::string& path, Budget& budget);

// Returns the list `key` of the root; empty if there is none. Throws Error if an entry is not an object.
const nlohmann::json& objects(const nlohmann::json& root, const char* key, const std::string& path);

// Returns a whole number 0..2^31-1, because tinygltf keeps most of them in an int. Throws Error, which names `what`.
uint64_t whole(const nlohmann::json& object, const char* key, uint64_t fallback, const std::string& what);

}  // namespace sideray::scenes::gltf
