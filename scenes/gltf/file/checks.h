// Checks offsets, indices and sizes that tinygltf uses unchecked, in our own parse of the JSON. Any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Each throws Error, which names the file.
void check_asset(const nlohmann::json& root, const std::string& path);
void check_structure(const nlohmann::json& root, const std::filesystem::path& folder, bool is_glb, File& file);
// Checks that bufferViews are inside their buffers, which later code relies on.
void check_loaded_buffers(const File& file);

// Replaces images that must not or cannot be read by a single byte, so that only those that the scene shows are errors.
// Returns whether there was such an image.
bool hide_broken_images(nlohmann::json& root, const std::filesystem::path& folder, File& file);

}  // namespace sideray::scenes::gltf
