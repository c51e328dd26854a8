// Handles the files that a glTF file names. Any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Rewrites URIs of buffers and images that tinygltf would not find, with a warning, and those that it would decode to
// another name than check_uri(), without. Returns whether there were any.
bool mend_uris(nlohmann::json& root, const std::filesystem::path& folder, File& file);

// Returns whether the file exists, and stands in the folder or below when links are followed.
bool is_below(const std::filesystem::path& folder, const std::filesystem::path& file);

// Throws Error, which names `path` and `user`, if the object's URI is neither data nor a file in the scene's folder: an
// untrusted scene must not read arbitrary files.
void check_uri(const nlohmann::json& object, const std::filesystem::path& folder, const std::string& path,
               const std::string& user);

}  // namespace sideray::scenes::gltf
