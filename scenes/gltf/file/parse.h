// Runs tinygltf on a file that was checked. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Fills file.model; reads the files that it names from `folder`. Throws Error.
void parse(std::span<const uint8_t> bytes, const std::string& folder, File& file);

}  // namespace sideray::scenes::gltf
