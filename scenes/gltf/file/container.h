// The container of a glTF file: JSON alone, or a binary file (.glb) of two chunks. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sideray::scenes::gltf {

bool is_binary(std::span<const uint8_t> bytes);

// The part of the file that is JSON. Throws Error, which names `path`, where the container is damaged.
std::span<const uint8_t> json_text(std::span<const uint8_t> bytes, const std::string& path);

// Files without buffers may end in a binary chunk of no bytes, which tinygltf takes for damage.
void drop_empty_chunk(std::vector<uint8_t>& bytes);

// The same file with other JSON. json_text() must have accepted it.
std::vector<uint8_t> with_json(std::span<const uint8_t> bytes, std::string json);

}  // namespace sideray::scenes::gltf
