#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "elementary/functions.h"
#include "scenes/content/hash.h"
#include "scenes/gltf/gltf_texture.h"

// Reads extras.sideray of nodes: properties of legacy content that glTF lacks.
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

struct WindNumber {
  const char* key;
  float sideray_wind_desc::*field;
  double low, high;
};

constexpr WindNumber wind_numbers[] = {{"amplitude", &sideray_wind_desc::amplitude, 0, 1e6},
                                       {"frequency", &sideray_wind_desc::frequency, 0, 1e3},
                                       {"height", &sideray_wind_desc::height, 1e-5, 1e6},
                                       {"branch_amplitude", &sideray_wind_desc::branch_amplitude, 0, 1e6},
                                       {"branch_frequency", &sideray_wind_desc::branch_frequency, 0, 1e3},
                                       {"leaf_amplitude", &sideray_wind_desc::leaf_amplitude, 0, 1e6},
                                       {"leaf_frequency", &sideray_wind_desc::leaf_frequency, 0, 1e3},
                                       {"wavelength", &sideray_wind_desc::wavelength, 1e-5, 1e6}};

double in_range(const File& file, const tinygltf::Value& wind, const char* key, double fallback, double low,
                double high, const std::string& user) {
  const double value = number(file, wind, key, fallback);
  if (!(value >= low && value <= high))
    refuse("cannot read {}: {} of wind of {} is {}; give {:g} to {:g}", file.path, key, user, value, low, high);
  return value;
}

// Reads a direction and normalizes it. A direction of unit length up to rounding keeps its bits, so that written files
// are read back equal.
void read_direction(const File& file, const tinygltf::Value& wind, const std::string& user, float direction[3]) {
  const std::vector<double> given = numbers(file, wind, "direction", {1, 0, 0});
  const double length = given.size() == 3 ? elementary::hypot(given[0], given[1], given[2]) : 0.0;
  if (!(length > 1e-6 && length < 1e6))
    refuse("cannot read {}: direction of wind of {} is no direction; give three numbers such as [1, 0, 0]", file.path,
           user);
  const double divisor = std::abs(length - 1.0) < 1e-5 ? 1.0 : length;
  for (size_t c = 0; c < 3; ++c) direction[c] = static_cast<float>(given[c] / divisor);
}

sideray_wind_desc read_wind(const File& file, const tinygltf::Value& wind, const std::string& user, Content& content) {
  sideray_wind_desc desc = sideray_wind_defaults();
  for (const WindNumber& n : wind_numbers)
    desc.*n.field = static_cast<float>(in_range(file, wind, n.key, double{desc.*n.field}, n.low, n.high, user));
  read_direction(file, wind, user, desc.direction);
  for (const std::string& key : wind.Keys()) {
    const bool is_known = key == "direction" || key == "phase" ||
                          std::any_of(std::begin(wind_numbers), std::end(wind_numbers),
                                      [&](const WindNumber& n) { return key == n.key; });
    if (!is_known) content.warnings.push_back(fmt::format("{}: {} of wind is unknown and left out", user, key));
  }
  return desc;
}

// Reads winds; nodes with the same numbers share one.
class WindReader {
 public:
  WindReader(const File& file, Content& content) : file_(file), content_(content) {}

  void read(const PlacedNode& placed, const tinygltf::Value& wind, const std::string& user) {
    if (!wind.IsObject()) refuse("cannot read {}: wind of {} is not an object; correct it", file_.path, user);
    const sideray_wind_desc desc = read_wind(file_, wind, user, content_);
    const double given = in_range(file_, wind, "phase", -1.0, wind.Has("phase") ? 0.0 : -1.0, 1.0, user);
    if (placed.object_count == 0) {
      content_.warnings.push_back(fmt::format("{}: has wind and nothing to move; left out", user));
      return;
    }
    const uint32_t index = index_of(desc);
    const bool is_given_each = has_wind_phases(file_.model.nodes[placed.node]);  // already read with the instances
    // Primitives of one instance move alike, so every mesh of the node counts instances from 0.
    uint32_t instance = 0;
    for (uint32_t k = 0; k < placed.object_count; ++k) {
      Object& object = content_.objects[placed.first_object + k];
      instance = k > 0 && object.mesh == (&object - 1)->mesh ? instance + 1 : 0;
      object.wind = index;
      if (is_given_each) continue;
      object.wind_phase =
          given >= 0.0 ? static_cast<float>(given) : hash01(static_cast<uint32_t>(placed.node), instance, phase_salt);
    }
  }

 private:
  uint32_t index_of(const sideray_wind_desc& d) {
    const Key key{d.direction[0],     d.direction[1],     d.direction[2],   d.amplitude,      d.frequency, d.height,
                  d.branch_amplitude, d.branch_frequency, d.leaf_amplitude, d.leaf_frequency, d.wavelength};
    const auto [found, is_new] = known_.try_emplace(key, static_cast<uint32_t>(content_.winds.size() + 1));
    if (is_new) content_.winds.push_back(d);
    return found->second;
  }

  using Key = std::array<float, 11>;
  const File& file_;
  Content& content_;
  static constexpr uint32_t phase_salt = 77;
  std::map<Key, uint32_t> known_;
};

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
  file.budget.take(emitter.particles.count * sizeof(sideray_sprite), "particles of node " + source.node);
  file.budget.check_time("particles");
  TextureUse use;
  use.index = emitter.particles.texture;
  emitter.texture = textures.slot(use, Colors::srgb, "particles of node " + source.node).texture;
  return emitter;
}

}  // namespace

void read_node_extras(const File& file, std::span<const PlacedNode> nodes, Content& content) {
  TextureReader textures(file, content);
  WindReader winds(file, content);
  for (const PlacedNode& placed : nodes) {
    const tinygltf::Node& node = file.model.nodes[placed.node];
    const tinygltf::Value* ours = sideray_extras(node.extras);
    if (ours == nullptr || placed.is_hidden) continue;
    const std::string name = node.name.empty() ? fmt::format("node{}", placed.node) : node.name;
    const std::string user = "node " + name;
    for (const std::string& key : ours->Keys()) {
      if (key == "wind") {
        winds.read(placed, ours->Get("wind"), user);
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
