// The JSON of a glTF file, refused where it is too large or not JSON, and values of it. Any thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "scenes/base/budget.h"

namespace sideray::scenes::gltf {

// Without line ends and the last full stop, and of a length that an error message can hold.
std::string one_line(std::string text);

// Takes what its values will need. Throws Error, which names `path`.
nlohmann::json parse_json(std::span<const uint8_t> text, const std::string& path, Budget& budget);

// The list `key` of the root; empty where it is absent. Throws Error where its entries are not objects.
const nlohmann::json& objects(const nlohmann::json& root, const char* key, const std::string& path);

// A whole number 0..2^31-1, as tinygltf keeps most of them in an int. Throws Error, which names `what`.
uint64_t whole(const nlohmann::json& object, const char* key, uint64_t fallback, const std::string& what);

}  // namespace sideray::scenes::gltf
