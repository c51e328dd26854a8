// Shared code of the scene tests: a temporary folder, and small glTF files made of parts. One thread.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "scenes/builtin/builtin.h"
#include "scenes/content/content.h"

namespace sideray::scenes {

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "sideray-scenes-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  size_t entries() const { return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(path_), {})); }

 private:
  std::filesystem::path path_;
};

inline std::vector<uint8_t> bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void put_bytes(const std::string& path, std::span<const uint8_t> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// The message of the Error that `action` throws; "" where it throws none.
template <typename Action>
std::string message_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// A .gltf with one .bin beside it. Starts as one triangle in the xy plane; tests change `json`.
struct SmallGltf {
  nlohmann::json json;
  std::vector<uint8_t> binary;

  SmallGltf() {
    json["asset"]["version"] = "2.0";
    json["accessors"] = nlohmann::json::array();
    const size_t positions = add(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
    json["meshes"] = {{{"name", "tri"}, {"primitives", {{{"attributes", {{"POSITION", positions}}}}}}}};
    json["nodes"] = {{{"name", "a"}, {"mesh", 0}}};
    json["scenes"] = {{{"nodes", {0}}}};
    json["scene"] = 0;
  }

  template <typename T>
  size_t add(const std::vector<T>& values, int component_type, const char* type, size_t count) {
    json["accessors"].push_back(
        {{"bufferView", add_view(values)}, {"componentType", component_type}, {"type", type}, {"count", count}});
    return json["accessors"].size() - 1;
  }
  template <typename T>
  size_t add_view(const std::vector<T>& values) {
    binary.resize((binary.size() + 3) / 4 * 4, 0);
    const auto* from = reinterpret_cast<const uint8_t*>(values.data());
    const size_t size = values.size() * sizeof(T);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", size}});
    binary.insert(binary.end(), from, from + size);
    return json["bufferViews"].size() - 1;
  }
  nlohmann::json& primitive() { return json["meshes"][0]["primitives"][0]; }

  std::string write(const ScratchFolder& folder) {
    if (!json.contains("buffers")) json["buffers"] = {{{"byteLength", binary.size()}, {"uri", "data.bin"}}};
    put_bytes(folder / "data.bin", binary);
    std::ofstream(folder / "scene.gltf") << json.dump();
    return folder / "scene.gltf";
  }
  Content load() {
    const ScratchFolder folder;
    return scenes::load_file(write(folder));
  }
  std::string load_error() {
    return message_of([&] { load(); });
  }
};

}  // namespace sideray::scenes
