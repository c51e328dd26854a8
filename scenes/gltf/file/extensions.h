// Knows the supported extensions of glTF. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/base/files.h"
#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Warns of used extensions that are not supported. Throws Error where one of these is required.
void check_extensions(const nlohmann::json& root, const std::string& path, Warnings& warnings);

}  // namespace sideray::scenes::gltf
