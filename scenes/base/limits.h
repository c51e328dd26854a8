// Lists the sizes above which reading refuses a scene; docs/limits.md gives the reasons. Plain constants; any thread.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sideray::scenes::limits {

// Files.
constexpr uint64_t scene_file_bytes = uint64_t{1} << 30;    // a .gltf, .glb, .bin or picture of a scene
constexpr uint64_t picture_file_bytes = uint64_t{1} << 32;  // a .png, .exr, .hdr given by itself
constexpr int json_depth = 64;                              // tinygltf reads nested values recursively
constexpr uint64_t json_values = uint64_t{1} << 23;
constexpr uint64_t json_value_bytes = 200;                  // about the memory that each value takes once read

// Geometry. Elements of an accessor without data take no bytes in the file: their limit is lower.
constexpr size_t accessor_elements = size_t{1} << 26;
constexpr size_t accessor_elements_without_data = size_t{1} << 22;
constexpr size_t mesh_numbers = size_t{1} << 30;       // floats and indices of all meshes: 4 GiB
constexpr size_t objects = size_t{1} << 22;            // drawn primitives, instances included
constexpr int node_depth = 1000;
constexpr size_t joints = 65535;                       // of a skin: vertices name them by 16 bits
constexpr size_t animation_numbers = size_t{1} << 27;  // key times and values of all animations: 512 MiB
constexpr size_t lights = 4096;                // the limit of a scene
constexpr double coordinate = 1e15;             // of positions, in scene units, and of transforms
constexpr double smallest_determinant = 1e-30;  // of transforms that draw anything

// Pictures.
constexpr uint32_t picture_side = 16384;
constexpr uint64_t picture_values = uint64_t{1} << 29;      // all channels of an .exr, .hdr or .png given by itself: 2 GiB
constexpr uint64_t jpeg_scan_texels = uint64_t{1} << 32;  // texels times scans of a JPEG: some seconds
constexpr uint64_t texels = uint64_t{1} << 29;      // decoded textures of one scene: 2 GiB

}  // namespace sideray::scenes::limits
