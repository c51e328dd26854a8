#include "scenes/gltf/file/mend.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "scenes/base/files.h"
#include "scenes/gltf/file/json.h"

namespace sideray::scenes::gltf {
namespace {

using Json = nlohmann::json;

// Returns whether the values of the key are whole numbers, or lists of them.
bool is_whole_by_name(const std::string& key) {
  static const std::set<std::string> names{
      "buffer", "bufferView", "byteLength", "byteOffset", "byteStride", "camera", "children", "componentType",
      "count", "index", "indices", "input", "inverseBindMatrices", "joints", "light", "magFilter", "material", "mesh",
      "minFilter", "mode", "node", "nodes", "output", "sampler", "scene", "skeleton", "skin", "source", "target",
      "texCoord", "wrapS", "wrapT"};
  return names.contains(key);
}

bool mend_number(Json& value) {
  const double number = value.get<double>();
  if (number != std::floor(number) || !(std::abs(number) < 9e15)) return false;
  value = static_cast<int64_t>(number);
  return true;
}

// Corrects numbers below `value`. With `all` every number is whole: in attributes keys are names chosen by the file.
bool mend_below(Json& value, bool is_whole, bool all) {
  if (value.is_number_float()) return is_whole && mend_number(value);
  bool changed = false;
  if (value.is_array()) {
    for (Json& element : value) changed |= mend_below(element, is_whole, all);
  } else if (value.is_object()) {
    for (const auto& [key, child] : value.items()) {
      if (key == "extras" || !(child.is_structured() || child.is_number_float())) continue;
      const bool lists_accessors = all || key == "attributes" || key == "targets";
      const bool holds_numbers = !child.is_object();
      changed |= mend_below(child, lists_accessors || (holds_numbers && is_whole_by_name(key)), lists_accessors);
    }
  }
  return changed;
}

// Returns whether the accessor has no elements.
bool is_empty(const Json& root, const Json& index) {
  const auto accessors = root.find("accessors");
  if (accessors == root.end() || !accessors->is_array() || !index.is_number_integer()) return false;
  const auto at = index.get<int64_t>();
  if (at < 0 || static_cast<size_t>(at) >= accessors->size()) return false;
  const Json& accessor = (*accessors)[static_cast<size_t>(at)];
  return accessor.is_object() && accessor.contains("count") && accessor["count"] == 0;
}

bool hide_if_empty(const Json& root, Json& primitive) {
  const Json::json_pointer position("/attributes/POSITION"), indices("/indices");
  const bool has_vertices = !primitive.contains(position) || !is_empty(root, primitive[position]);
  if (has_vertices && !(primitive.contains(indices) && is_empty(root, primitive[indices]))) return false;
  primitive = {{"attributes", Json::object()}};
  return true;
}

bool is_whole_camera(const Json& camera) {
  static const std::map<std::string, std::vector<const char*>> wanted{
      {"perspective", {"yfov", "znear"}}, {"orthographic", {"xmag", "ymag", "zfar", "znear"}}};
  const Json type = camera.value("type", Json());
  const auto keys = type.is_string() ? wanted.find(type.get<std::string>()) : wanted.end();
  if (keys == wanted.end() || !camera.contains(keys->first) || !camera[keys->first].is_object()) return false;
  const Json& numbers = camera[keys->first];
  return std::all_of(keys->second.begin(), keys->second.end(),
                     [&](const char* key) { return numbers.contains(key) && numbers[key].is_number(); });
}

}  // namespace

bool drop_nulls(Json& root) {
  const size_t before = root.size();
  for (auto entry = root.begin(); entry != root.end();) entry = entry->is_null() ? root.erase(entry) : std::next(entry);
  return root.size() != before;
}

bool mend_numbers(Json& root) {
  return mend_below(root, false, false);
}

bool hide_empty_primitives(Json& root) {
  const auto meshes = root.find("meshes");
  if (meshes == root.end() || !meshes->is_array()) return false;
  bool changed = false;
  for (Json& mesh : *meshes) {
    if (!mesh.is_object() || !mesh.contains("primitives") || !mesh["primitives"].is_array()) continue;
    for (Json& primitive : mesh["primitives"])
      changed |= primitive.is_object() && hide_if_empty(root, primitive);
  }
  return changed;
}

bool mend_spots(Json& root) {
  const Json::json_pointer lights("/extensions/KHR_lights_punctual/lights");
  if (!root.contains(lights) || !root[lights].is_array()) return false;
  bool changed = false;
  for (Json& light : root[lights]) {
    if (!light.is_object() || light.value("type", Json()) != "spot" || light.contains("spot")) continue;
    light["spot"] = Json::object();
    changed = true;
  }
  return changed;
}

bool mend_targets(Json& root) {
  const auto animations = root.find("animations");
  if (animations == root.end() || !animations->is_array()) return false;
  bool changed = false;
  for (Json& animation : *animations) {
    if (!animation.is_object() || !animation.contains("channels") || !animation["channels"].is_array()) continue;
    for (Json& channel : animation["channels"]) {
      const bool has_target = channel.is_object() && channel.contains("target") && channel["target"].is_object();
      if (!has_target || channel["target"].contains("node")) continue;
      channel["target"]["node"] = -1;
      changed = true;
    }
  }
  return changed;
}

std::set<size_t> hide_broken_cameras(Json& root) {
  std::set<size_t> broken;
  const auto cameras = root.find("cameras");
  if (cameras == root.end() || !cameras->is_array()) return broken;
  for (size_t i = 0; i < cameras->size(); ++i) {
    Json& camera = (*cameras)[i];
    if (!camera.is_object() || is_whole_camera(camera)) continue;
    camera["type"] = "perspective";
    camera["perspective"] = {{"yfov", 1}, {"znear", 1}};
    broken.insert(i);
  }
  return broken;
}

bool point_at_compressed(Json& root, const std::string& path) {
  constexpr const char* name = "EXT_meshopt_compression";
  const auto extension_of = [&](Json& object) -> const Json* {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object() || !extensions->contains(name)) return nullptr;
    const Json& found = extensions->at(name);
    if (!found.is_object()) refuse("cannot read {}: an extension {} is not an object; export it again", path, name);
    return &found;
  };
  bool changed = false;
  for (size_t i = 0; i < objects(root, "buffers", path).size(); ++i) {
    Json& buffer = root["buffers"][i];
    const Json* e = extension_of(buffer);
    if (e == nullptr || !e->contains("fallback") || e->at("fallback") != true) continue;
    buffer["byteLength"] = 1;
    buffer["uri"] = "data:application/octet-stream;base64,AA==";
    changed = true;
  }
  for (size_t i = 0; i < objects(root, "bufferViews", path).size(); ++i) {
    Json& view = root["bufferViews"][i];
    const Json* e = extension_of(view);
    if (e == nullptr) continue;
    for (const char* key : {"buffer", "byteOffset", "byteLength"}) {
      if (e->contains(key))
        view[key] = e->at(key);
      else
        view.erase(key);
    }
    changed = true;
  }
  return changed;
}

bool hide_draco_indices(Json& root, const std::string& path) {
  constexpr const char* name = "KHR_draco_mesh_compression";
  bool changed = false;
  for (size_t i = 0; i < objects(root, "meshes", path).size(); ++i) {
    const auto primitives = root["meshes"][i].find("primitives");
    if (primitives == root["meshes"][i].end() || !primitives->is_array()) continue;
    for (Json& primitive : *primitives) {
      const Json::json_pointer e = Json::json_pointer("/extensions") / name;
      if (!primitive.is_object() || !primitive.contains(e) || !primitive[e].is_object()) continue;
      if (!primitive.contains("indices")) continue;
      primitive[e]["indices"] = primitive["indices"];
      primitive.erase("indices");
      changed = true;
    }
  }
  return changed;
}

}  // namespace sideray::scenes::gltf
