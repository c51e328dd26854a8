// The JSON of a glTF file, refused where it is too large or not JSON. Any thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

namespace sideray::scenes::gltf {

// Without line ends and the last full stop, and of a length that an error message can hold.
std::string one_line(std::string text);

// Throws Error, which names `path`.
nlohmann::json parse_json(std::span<const uint8_t> text, const std::string& path);

}  // namespace sideray::scenes::gltf
