#include "scenes/gltf/gltf_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {
namespace {

using Json = nlohmann::json;

// The parser's message without its identifier, and without the marks that part our lines into "what: why; what to do".
std::string json_reason(std::string text) {
  const size_t identifier = text.find("] ");
  if (text.starts_with('[') && identifier != std::string::npos) text.erase(0, identifier + 2);
  for (const char* mark : {": ", "; "}) {
    for (size_t at = text.find(mark); at != std::string::npos; at = text.find(mark)) text[at] = ',';
  }
  return one_line(std::move(text));
}

// Looks at a text before anything is made of it. A callback of the parser that makes values could do so too, but
// searches the list around an object at each object's end, which takes hours for a list of a million nodes.
class JsonLimits : public nlohmann::json_sax<Json> {
 public:
  JsonLimits(const std::string& path, Budget& budget) : path_(path), budget_(budget) {}
  bool null() override { return count(); }
  bool boolean(bool) override { return count(); }
  bool number_integer(number_integer_t) override { return count(); }
  bool number_unsigned(number_unsigned_t) override { return count(); }
  bool number_float(number_float_t, const string_t&) override { return count(); }
  bool string(string_t&) override { return count(); }
  bool binary(binary_t&) override { return count(); }
  bool key(string_t&) override { return count(); }
  bool start_object(size_t) override { return count() && ++depth_ > 0; }
  bool start_array(size_t) override { return count() && ++depth_ > 0; }
  bool end_object() override { return depth_-- > 0; }
  bool end_array() override { return depth_-- > 0; }
  bool parse_error(size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

 private:
  bool count() {
    if (depth_ > limits::json_depth)
      refuse("cannot read {}: its JSON is nested deeper than {}; export it again", path_, limits::json_depth);
    if (++values_ > limits::json_values)
      refuse("cannot read {}: its JSON has more than {} values; keep numbers in buffers", path_, limits::json_values);
    if (values_ % chunk != 1) return true;
    budget_.take(chunk * limits::json_value_bytes, "its JSON");
    budget_.check_time("its JSON");
    return true;
  }
  static constexpr uint64_t chunk = 4096;
  const std::string& path_;
  Budget& budget_;
  int depth_ = 0;
  uint64_t values_ = 0;
};

// Keys of glTF whose values are whole numbers, or lists of them.
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

// `all`: inside of attributes, whose keys are names of the file.
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

// Returns whether the accessor says that it has no elements.
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

std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  if (text.ends_with('.')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.size() > 300 ? text.substr(0, 300) + "..." : text;
}

Json parse_json(std::span<const uint8_t> text, const std::string& path, Budget& budget) {
  const auto first = std::find_if(text.begin(), text.end(), [](uint8_t c) { return std::isspace(c) == 0; });
  const bool marked = first != text.end() && *first == 0xef;  // of a byte order
  if (first != text.end() && *first != '{' && !marked)
    refuse("cannot read {}: it is neither binary glTF nor JSON; get it again or export it again", path);
  JsonLimits sizes(path, budget);
  Json::sax_parse(text.begin(), text.end(), &sizes);
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::exception& error) {
    refuse("cannot read {}: {}; export it again", path, json_reason(error.what()));
  }
}

}  // namespace sideray::scenes::gltf
