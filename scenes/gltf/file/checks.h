// What tinygltf follows without asking (offsets, indices, sizes) is checked on our own parse of the JSON. Any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Each throws Error, which names the file.
void check_asset(const nlohmann::json& root, const std::string& path);
void check_structure(const nlohmann::json& root, const std::filesystem::path& folder, bool is_glb, File& file);
// Later code indexes buffers through bufferViews without asking again.
void check_loaded_buffers(const File& file);

// Puts a byte in place of each image that must not or cannot be read: it is missed only where something shown uses it.
// Returns whether there was such an image.
bool hide_broken_images(nlohmann::json& root, const std::filesystem::path& folder, File& file);

}  // namespace sideray::scenes::gltf
