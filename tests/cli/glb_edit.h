// A .glb file whose JSON is changed, as an editor would. Test support.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

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

inline nlohmann::json& node_named(nlohmann::json& gltf, const std::string& name) {
  for (nlohmann::json& node : gltf["nodes"])
    if (node.value("name", "") == name) return node;
  throw std::runtime_error("no node " + name);
}

}  // namespace sideray::cli_tests
