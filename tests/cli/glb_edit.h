// Changes the JSON of a .glb file, as an editor would. Test support.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/program.h"

namespace sideray::cli_tests {

inline void edit_glb(const std::string& path, const std::function<void(nlohmann::json& gltf)>& change) {
  constexpr size_t head = 12, chunk_head = 8;
  const std::string bytes = text_of(path);
  uint32_t length = 0;
  std::memcpy(&length, bytes.data() + head, sizeof(length));
  nlohmann::json gltf = nlohmann::json::parse(bytes.substr(head + chunk_head, length));
  change(gltf);
  std::string json = gltf.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string rest = bytes.substr(head + chunk_head + length);
  const auto number = [](size_t value) {
    const auto narrow = static_cast<uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&narrow), sizeof(narrow));
  };
  std::ofstream(path, std::ios::binary) << bytes.substr(0, 8) << number(head + chunk_head + json.size() + rest.size())
                                        << number(json.size()) << "JSON" << json << rest;
}

inline std::string base64(const std::vector<float>& values) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
  const size_t size = values.size() * sizeof(float);
  std::string text;
  for (size_t i = 0; i < size; i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < size ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) text += i + k > size ? '=' : digits[word >> (18 - 6 * k) & 63];
  }
  return text;
}

// Adds numbers as a buffer, and returns their accessor.
inline int accessor_of(nlohmann::json& gltf, const std::vector<float>& values, size_t components) {
  const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  const size_t bytes = values.size() * sizeof(float);
  gltf["buffers"].push_back({{"byteLength", bytes}, {"uri", "data:application/octet-stream;base64," + base64(values)}});
  gltf["bufferViews"].push_back({{"buffer", gltf["buffers"].size() - 1}, {"byteLength", bytes}});
  gltf["accessors"].push_back({{"bufferView", gltf["bufferViews"].size() - 1},
                               {"componentType", 5126},
                               {"type", types[components]},
                               {"count", values.size() / components}});
  return static_cast<int>(gltf["accessors"].size() - 1);
}

inline nlohmann::json& node_named(nlohmann::json& gltf, const std::string& name) {
  for (nlohmann::json& node : gltf["nodes"])
    if (node.value("name", "") == name) return node;
  throw std::runtime_error("no node " + name);
}

}  // namespace sideray::cli_tests
