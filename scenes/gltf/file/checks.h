// Checks on our own parse of the JSON the offsets, indices and sizes that tinygltf uses unchecked. Any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// All of these throw Error, which names the file.
void check_asset(const nlohmann::json& root, const std::string& path);
void check_structure(const nlohmann::json& root, const std::filesystem::path& folder, bool is_glb, File& file);
// Checks what bufferViews say of buffers, because later code relies on it.
void check_loaded_buffers(const File& file);

// Replaces each image that must not or cannot be read by a single byte, so that the error appears only if something
// visible uses the image. Returns whether there was such an image.
bool hide_broken_images(nlohmann::json& root, const std::filesystem::path& folder, File& file);

}  // namespace sideray::scenes::gltf
