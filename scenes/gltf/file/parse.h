// Parses a checked file by tinygltf. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Fills file.model, and reads the files in `folder` that it names. Throws Error.
void parse(std::span<const uint8_t> bytes, const std::string& folder, File& file);

}  // namespace sideray::scenes::gltf
