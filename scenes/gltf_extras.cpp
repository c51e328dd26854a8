#include <algorithm>
#include <nlohmann/json.hpp>

#include "scenes/gltf_texture.h"

// extras.sideray of nodes: what legacy content knows of a node and glTF does not. Kept as it is for its later readers.
namespace sideray::scenes::gltf {
namespace {

using Json = nlohmann::json;

Json json_of(const tinygltf::Value& value) {
  if (value.IsBool()) return value.Get<bool>();
  if (value.IsInt()) return value.Get<int>();
  if (value.IsNumber()) return value.GetNumberAsDouble();
  if (value.IsString()) return value.Get<std::string>();
  if (value.IsArray()) {
    Json array = Json::array();
    for (size_t i = 0; i < value.ArrayLen(); ++i) array.push_back(json_of(value.Get(static_cast<int>(i))));
    return array;
  }
  if (!value.IsObject()) return nullptr;
  Json object = Json::object();
  for (const std::string& key : value.Keys()) object[key] = json_of(value.Get(key));
  return object;
}

std::string text_of(const File& file, const tinygltf::Value& ours, const char* key, const std::string& user) {
  const tinygltf::Value& value = ours.Get(key);
  if (!value.IsObject()) refuse("cannot read {}: {} of {} is not an object; correct it", file.path, key, user);
  return json_of(value).dump(-1, ' ', false, Json::error_handler_t::replace);
}

void check_wind(const File& file, const tinygltf::Value& wind, const std::string& user) {
  for (const char* key : {"amplitude", "frequency"}) {
    const double value = number(file, wind, key, 0.0);
    if (!(value >= 0.0)) {
      refuse("cannot read {}: {} of wind of {} is {}; give 0 or more", file.path, key, user, value);
    }
  }
}

struct NamedJson {
  std::string node, json;
};

Emitter read_emitter(const File& file, const PlacedNode& placed, const NamedJson& source, TextureReader& textures,
                     Content& content) {
  Emitter emitter{};
  emitter.node = source.node;
  emitter.json = source.json;
  for (int i = 0; i < 12; ++i) emitter.world_from_node[i] = placed.world_from_node[i / 3][i % 3];
  emitter.particles = parse_particles(file.path, source.node, source.json, content.warnings);
  TextureUse use;
  use.index = emitter.particles.texture;
  emitter.texture = textures.slot(use, Colors::srgb, "particles of node " + source.node).texture;
  return emitter;
}

}  // namespace

void read_node_extras(const File& file, std::span<const PlacedNode> nodes, Content& content) {
  TextureReader textures(file, content);
  for (const PlacedNode& placed : nodes) {
    const tinygltf::Node& node = file.model.nodes[placed.node];
    const tinygltf::Value* ours = sideray_extras(node.extras);
    if (ours == nullptr) continue;
    const std::string name = node.name.empty() ? fmt::format("node{}", placed.node) : node.name;
    const std::string user = "node " + name;
    for (const std::string& key : ours->Keys()) {
      if (key == "wind") {
        Wind wind{name, text_of(file, *ours, "wind", user)};
        check_wind(file, ours->Get("wind"), user);
        const bool is_known = std::any_of(content.winds.begin(), content.winds.end(), [&](const Wind& other) {
          return other.node == wind.node && other.json == wind.json;
        });
        if (!is_known) content.winds.push_back(std::move(wind));
      } else if (key == "particles") {
        content.emitters.push_back(
            read_emitter(file, placed, {name, text_of(file, *ours, "particles", user)}, textures, content));
      } else {
        content.warnings.push_back(fmt::format("{}: extras.sideray.{} is unknown and left out", user, key));
      }
    }
  }
}

}  // namespace sideray::scenes::gltf
