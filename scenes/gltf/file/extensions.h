// Knows which glTF extensions are read. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/base/files.h"
#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Warns of extensions that are used but not read, and throws Error if such an extension is required.
void check_extensions(const nlohmann::json& root, const std::string& path, Warnings& warnings);

}  // namespace sideray::scenes::gltf
