// Checks the names of files in a glTF file. Any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Rewrites URIs of buffers and images that tinygltf would not find, with a warning. Returns whether there were any.
bool mend_uris(nlohmann::json& root, const std::filesystem::path& folder, File& file);

// Throws Error, which names `path` and `user`, where the object's URI is neither data nor a file in the scene's folder:
// a scene must not read other files.
void check_uri(const nlohmann::json& object, const std::filesystem::path& folder, const std::string& path,
               const std::string& user);

}  // namespace sideray::scenes::gltf
