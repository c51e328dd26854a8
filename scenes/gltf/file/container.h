// Splits a glTF file: JSON alone, or a binary file (.glb) of two chunks. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sideray::scenes::gltf {

bool is_binary(std::span<const uint8_t> bytes);

// Returns the JSON in the file. Throws Error, which names `path`, where the container is damaged.
std::span<const uint8_t> json_text(std::span<const uint8_t> bytes, const std::string& path);

// Removes an empty binary chunk at the end, which files without buffers may have and tinygltf refuses.
void drop_empty_chunk(std::vector<uint8_t>& bytes);

// Returns the file with other JSON; json_text() must have accepted it.
std::vector<uint8_t> with_json(std::span<const uint8_t> bytes, std::string json);

}  // namespace sideray::scenes::gltf
