#include "fuzz/grammar.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace sideray::fuzz {
namespace {

using Json = nlohmann::json;

constexpr int ubyte = 5121, ushort = 5123, single = 5126;

std::string base64(const std::vector<uint8_t>& bytes) {
  static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k) three = three << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : letters[three >> (18 - 6 * k) & 63];
  }
  return text;
}

// A PNG of one grey texel.
constexpr const char* grey_png =
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR42mNo"
    "AAAAggCB2kUIOwAAAABJRU5ErkJggg==";

class Document {
 public:
  explicit Document(Random& random) : random_(random) {}

  Json make() {
    json_["asset"] = {{"version", "2.0"}};
    if (random_.one_in(3)) add_materials();
    const uint32_t meshes = 1 + random_.below(3);
    for (uint32_t i = 0; i < meshes; ++i) add_mesh();
    add_nodes();
    if (random_.one_in(3)) add_animation();
    if (random_.one_in(4)) add_pointer();
    if (random_.one_in(6)) add_variants();
    const std::string data = "data:application/octet-stream;base64," + base64(bytes_);
    json_["buffers"] = {{{"byteLength", bytes_.size()}, {"uri", data}}};
    return std::move(json_);
  }

 private:
  template <typename T>
  size_t add(const std::vector<T>& values, int component, const char* type, size_t count) {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    const size_t at = bytes_.size(), length = values.size() * sizeof(T);
    bytes_.resize(at + length);
    if (length > 0) std::memcpy(&bytes_[at], values.data(), length);
    json_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at}, {"byteLength", length}});
    const size_t view = json_["bufferViews"].size() - 1;
    json_["accessors"].push_back(
        {{"bufferView", view}, {"componentType", component}, {"type", type}, {"count", count}});
    if (random_.one_in(12)) make_sparse(json_["accessors"].back(), values, component, count);
    return json_["accessors"].size() - 1;
  }

  // Replaces the first element by the same numbers.
  template <typename T>
  void make_sparse(Json& accessor, const std::vector<T>& values, int, size_t count) {
    const size_t at = bytes_.size(), element = values.size() / count * sizeof(T);
    bytes_.resize(at + 4 + element);
    std::memcpy(&bytes_[at + 4], values.data(), element);
    json_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at}, {"byteLength", 4}});
    json_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at + 4}, {"byteLength", element}});
    const size_t views = json_["bufferViews"].size();
    accessor["sparse"] = {{"count", 1},
                          {"indices", {{"bufferView", views - 2}, {"componentType", ushort}}},
                          {"values", {{"bufferView", views - 1}}}};
  }

  std::vector<float> floats(size_t count, double low, double high) {
    std::vector<float> values(count);
    for (float& value : values) value = static_cast<float>(random_.between(low, high));
    return values;
  }
  // Vectors of length 1.
  std::vector<float> units(size_t count, size_t components, double fourth) {
    std::vector<float> values;
    for (size_t i = 0; i < count; ++i) {
      const double a = random_.between(0, 6.28), z = random_.between(-0.99, 0.99), r = std::sqrt(1 - z * z);
      for (const double v : {r * std::cos(a), r * std::sin(a), z}) values.push_back(static_cast<float>(v));
      if (components == 4) values.push_back(static_cast<float>(fourth));
    }
    return values;
  }

  Json texture(bool second_set) {
    const auto index = random_.below(static_cast<uint32_t>(json_["textures"].size()));
    Json info = {{"index", index}};
    if (second_set && random_.one_in(3)) info["texCoord"] = 1;
    if (random_.one_in(4))
      info["extensions"]["KHR_texture_transform"] = {{"offset", {0.1, 0.2}}, {"rotation", 0.3}, {"scale", {2, 3}}};
    return info;
  }

  void add_materials() {
    json_["images"] = {{{"uri", grey_png}}};
    json_["samplers"] = {{{"wrapS", random_.pick({33071, 33648, 10497})}, {"magFilter", random_.pick({9728, 9729})}}};
    json_["textures"] = {{{"source", 0}}, {{"source", 0}, {"sampler", 0}}};
    const uint32_t count = 1 + random_.below(3);
    for (uint32_t i = 0; i < count; ++i) add_material();
  }

  void add_material() {
    Json material;
    Json& base = material["pbrMetallicRoughness"];
    base["baseColorFactor"] = {random_.unit(), random_.unit(), random_.unit(), random_.unit()};
    base["metallicFactor"] = random_.unit(), base["roughnessFactor"] = random_.unit();
    if (random_.one_in(2)) base["baseColorTexture"] = texture(true);
    if (random_.one_in(3)) material["normalTexture"] = texture(false);
    if (random_.one_in(3)) material["emissiveFactor"] = {random_.unit(), 0, 1};
    material["alphaMode"] = random_.pick({"OPAQUE", "MASK", "BLEND"});
    material["doubleSided"] = random_.one_in(2);
    add_lobes(material["extensions"]);
    if (random_.one_in(6)) material["extras"]["sideray"] = {{"rayTraced", true}, {"distortion", 0.1}};
    json_["materials"].push_back(material);
  }

  // Each an extension with one factor and, at times, its texture.
  void add_lobes(Json& extensions) {
    struct Lobe {
      const char *extension, *factor, *texture;
      double high;
    };
    static constexpr Lobe lobes[] = {{"KHR_materials_transmission", "transmissionFactor", "transmissionTexture", 1},
                                     {"KHR_materials_volume", "thicknessFactor", "thicknessTexture", 2},
                                     {"KHR_materials_specular", "specularFactor", "specularTexture", 1},
                                     {"KHR_materials_clearcoat", "clearcoatFactor", "clearcoatNormalTexture", 1},
                                     {"KHR_materials_sheen", "sheenRoughnessFactor", "sheenColorTexture", 1},
                                     {"KHR_materials_diffuse_transmission", "diffuseTransmissionFactor",
                                      "diffuseTransmissionTexture", 1},
                                     {"KHR_materials_iridescence", "iridescenceFactor", "iridescenceTexture", 1},
                                     {"KHR_materials_anisotropy", "anisotropyStrength", "anisotropyTexture", 1},
                                     {"KHR_materials_emissive_strength", "emissiveStrength", nullptr, 9},
                                     {"KHR_materials_dispersion", "dispersion", nullptr, 1},
                                     {"KHR_materials_pbrSpecularGlossiness", "glossinessFactor", "diffuseTexture", 1}};
    extensions = Json::object();
    for (const Lobe& lobe : lobes) {
      if (!random_.one_in(5)) continue;
      extensions[lobe.extension][lobe.factor] = random_.between(0, lobe.high);
      if (lobe.texture != nullptr && random_.one_in(2)) extensions[lobe.extension][lobe.texture] = texture(false);
    }
    if (random_.one_in(5)) extensions["KHR_materials_anisotropy"]["anisotropyRotation"] = random_.between(-7, 7);
    if (random_.one_in(5)) {
      Json& film = extensions["KHR_materials_iridescence"];
      film["iridescenceIor"] = random_.between(1, 2.5);
      film["iridescenceThicknessMinimum"] = random_.between(0, 500);
      film["iridescenceThicknessMaximum"] = random_.between(0, 1500);
      if (random_.one_in(2)) film["iridescenceThicknessTexture"] = texture(false);
    }
    if (random_.one_in(9))
      extensions["KHR_materials_volume_scatter"] = {{"multiscatterColorFactor", {random_.between(0, 1), 0.5, 1}},
                                                    {"scatterAnisotropy", random_.between(-0.9, 0.9)}};
    if (random_.one_in(5)) extensions["KHR_materials_ior"] = {{"ior", random_.between(1, 2.5)}};
    if (random_.one_in(9)) extensions["KHR_materials_unlit"] = Json::object();
  }

  void add_mesh() {
    Json primitives = Json::array();
    const uint32_t count = 1 + random_.below(2), targets = random_.one_in(4) ? 1 + random_.below(3) : 0;
    for (uint32_t i = 0; i < count; ++i) primitives.push_back(primitive(targets));
    Json mesh = {{"primitives", primitives}};
    if (targets > 0 && random_.one_in(2)) mesh["weights"] = std::vector<double>(targets, 0.5);
    targets_.push_back(targets);
    json_["meshes"].push_back(mesh);
  }

  Json primitive(uint32_t targets) {
    const size_t vertices = 3 * (1 + random_.below(4));
    Json result, &attributes = result["attributes"];
    attributes["POSITION"] = add(floats(3 * vertices, -5, 5), single, "VEC3", vertices);
    if (random_.one_in(2)) attributes["NORMAL"] = add(units(vertices, 3, 0), single, "VEC3", vertices);
    if (random_.one_in(3)) attributes["TANGENT"] = add(units(vertices, 4, 1), single, "VEC4", vertices);
    for (const char* set : {"TEXCOORD_0", "TEXCOORD_1"})
      if (random_.one_in(2)) attributes[set] = add(floats(2 * vertices, 0, 1), single, "VEC2", vertices);
    if (random_.one_in(4)) {
      attributes["COLOR_0"] = add(std::vector<uint8_t>(4 * vertices, 200), ubyte, "VEC4", vertices);
      json_["accessors"].back()["normalized"] = true;
    }
    if (random_.one_in(3)) add_joints(attributes, vertices);
    if (random_.one_in(2)) add_indices(result, vertices);
    if (random_.one_in(3)) result["mode"] = random_.pick({0, 1, 2, 3, 4, 5, 6});
    if (json_.contains("materials") && random_.one_in(2))
      result["material"] = random_.below(static_cast<uint32_t>(json_["materials"].size()));
    for (uint32_t i = 0; i < targets; ++i)
      result["targets"].push_back({{"POSITION", add(floats(3 * vertices, -1, 1), single, "VEC3", vertices)}});
    return result;
  }

  void add_joints(Json& attributes, size_t vertices) {
    attributes["JOINTS_0"] = add(std::vector<uint8_t>(4 * vertices, 0), ubyte, "VEC4", vertices);
    attributes["WEIGHTS_0"] = add(floats(4 * vertices, 0, 1), single, "VEC4", vertices);
  }

  void add_indices(Json& primitive, size_t vertices) {
    const size_t count = 3 * (1 + random_.below(5));
    std::vector<uint16_t> indices(count);
    for (uint16_t& index : indices) index = static_cast<uint16_t>(random_.below(static_cast<uint32_t>(vertices)));
    primitive["indices"] = add(indices, ushort, "SCALAR", count);
  }

  void add_nodes() {
    const uint32_t count = 1 + random_.below(6);
    Json roots = Json::array();
    for (uint32_t i = 0; i < count; ++i) {
      Json node;
      if (i > 0 && random_.one_in(2))
        json_["nodes"][random_.below(i)]["children"].push_back(i);
      else
        roots.push_back(i);
      place(node);
      carry(node, i);
      json_["nodes"].push_back(node.is_null() ? Json::object() : node);
    }
    json_["scenes"] = {{{"nodes", roots}}};
    if (random_.one_in(2)) json_["scene"] = 0;
    if (json_.contains("skins")) json_["skins"][0]["joints"] = {0};
  }

  void place(Json& node) {
    if (random_.one_in(2)) node["translation"] = {random_.between(-9, 9), random_.between(-9, 9), 0};
    if (random_.one_in(3)) node["rotation"] = {0, 0.7071067811865476, 0, 0.7071067811865476};
    if (random_.one_in(3)) node["scale"] = {random_.between(0.1, 3), random_.between(-3, -0.1), 1};
  }

  void carry(Json& node, uint32_t index) {
    if (index == 0 || random_.one_in(2)) carry_mesh(node);
    if (random_.one_in(4)) carry_camera(node);
    if (random_.one_in(4)) carry_light(node);
    if (random_.one_in(6))
      node["extras"]["sideray"]["wind"] = {{"amplitude", random_.unit()}, {"phase", random_.unit()}};
    if (random_.one_in(9))
      node["extras"]["sideray"]["particles"] = {{"count", 1 + random_.below(20)}, {"lifetime", 1}, {"size", 1}};
  }

  void carry_mesh(Json& node) {
    const uint32_t mesh = random_.below(static_cast<uint32_t>(json_["meshes"].size()));
    node["mesh"] = mesh;
    if (targets_[mesh] > 0 && random_.one_in(2)) node["weights"] = std::vector<double>(targets_[mesh], 0.25);
    if (random_.one_in(5)) {
      node["skin"] = 0;
      json_["skins"] = {{{"joints", {0}}}};
    } else if (random_.one_in(5)) {
      const size_t instances = 1 + random_.below(4);
      node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
          add(floats(3 * instances, -3, 3), single, "VEC3", instances);
    }
  }

  void carry_camera(Json& node) {
    if (random_.one_in(2))
      json_["cameras"].push_back(
          {{"type", "perspective"}, {"perspective", {{"yfov", random_.between(0.1, 2)}, {"znear", 0.1}}}});
    else
      json_["cameras"].push_back({{"type", "orthographic"},
                                  {"orthographic", {{"xmag", 1}, {"ymag", 2}, {"znear", 0}, {"zfar", 10}}}});
    node["camera"] = json_["cameras"].size() - 1;
  }

  void carry_light(Json& node) {
    Json& lights = json_["extensions"]["KHR_lights_punctual"]["lights"];
    Json light = {{"type", random_.pick({"directional", "point", "spot"})}, {"intensity", random_.between(0, 9)}};
    if (light["type"] == "spot") light["spot"] = {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.5}};
    lights.push_back(light);
    node["extensions"]["KHR_lights_punctual"] = {{"light", lights.size() - 1}};
  }

  void add_animation() {
    const size_t keys = 1 + random_.below(4);
    std::vector<float> times(keys);
    for (size_t i = 0; i < keys; ++i) times[i] = static_cast<float>(i);
    const size_t input = add(times, single, "SCALAR", keys);
    const char* path = random_.pick({"translation", "rotation", "scale"});
    const bool turns = path == std::string("rotation");
    const bool cubic = random_.one_in(4);
    const size_t count = keys * (cubic ? 3 : 1);
    const size_t output = turns ? add(units(count, 4, 0.5), single, "VEC4", count)
                                : add(floats(3 * count, 0.5, 2), single, "VEC3", count);
    Json sampler = {{"input", input}, {"output", output}};
    if (cubic) sampler["interpolation"] = "CUBICSPLINE";
    const auto node = random_.below(static_cast<uint32_t>(json_["nodes"].size()));
    const Json channel = {{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}};
    Json animation;
    animation["samplers"].push_back(sampler);
    animation["channels"].push_back(channel);
    json_["animations"].push_back(animation);
  }

  // Lets a channel animate a property by a pointer, if it exists.
  void add_pointer() {
    struct Pointed {
      const char* pointer;
      uint32_t numbers;
    };
    static constexpr Pointed all[] = {
        {"/materials/0/pbrMetallicRoughness/baseColorFactor", 4},
        {"/materials/0/emissiveFactor", 3},
        {"/materials/0/extensions/KHR_materials_transmission/transmissionFactor", 1},
        {"/materials/0/extensions/KHR_materials_volume/thicknessFactor", 1},
        {"/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/scale", 2},
        {"/extensions/KHR_lights_punctual/lights/0/intensity", 1},
        {"/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", 1},
        {"/cameras/0/perspective/yfov", 1},
        {"/nodes/0/extensions/KHR_node_visibility/visible", 1},
        {"/nodes/0/translation", 3}};
    const Pointed& pointed = all[random_.below(std::size(all))];
    const std::string owner = std::string(pointed.pointer).substr(0, std::string(pointed.pointer).find("/0/") + 2);
    if (!json_.contains(Json::json_pointer(owner))) return;
    const size_t keys = 1 + random_.below(3);
    std::vector<float> times(keys);
    for (size_t i = 0; i < keys; ++i) times[i] = static_cast<float>(i);
    const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const size_t input = add(times, single, "SCALAR", keys);
    const size_t output = add(floats(pointed.numbers * keys, -1, 3), single, types[pointed.numbers], keys);
    const Json target = {{"path", "pointer"},
                         {"extensions", {{"KHR_animation_pointer", {{"pointer", pointed.pointer}}}}}};
    Json animation;
    animation["samplers"].push_back({{"input", input}, {"output", output}});
    animation["channels"].push_back({{"sampler", 0}, {"target", target}});
    json_["animations"].push_back(animation);
    if (random_.one_in(2)) json_["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = random_.one_in(2);
  }

  void add_variants() {
    json_["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "a"}}, {{"name", "b"}}};
    json_["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] = {
        {{"material", random_.below(2)}, {"variants", {random_.below(2)}}}};
  }

  Random& random_;
  Json json_;
  std::vector<uint8_t> bytes_;
  std::vector<uint32_t> targets_;  // of each mesh
};

// Every value of the document, for one to be chosen.
void collect(Json& value, std::vector<Json*>& all) {
  all.push_back(&value);
  if (value.is_structured())
    for (Json& child : value) collect(child, all);
}

Json odd_value(Random& random) {
  switch (random.below(14)) {
    case 0:
      return nullptr;
    case 1:
      return random.one_in(2);
    case 2:
      return -1;
    case 3:
      return random.pick<int64_t>({2147483647, 2147483648, 4294967295, 9223372036854775807});
    case 4:
      return random.pick({1e300, -1e300, 1e-300, 1e39, 1e15, 1.0000001, -0.0, 0.5});
    case 5:
      return random.pick({"", "x", "MAT4", "VEC2", "SCALAR", "MAT3", "rotation", "weights", "CUBICSPLINE", "../a"});
    case 6:
      return Json::array();
    case 7:
      return Json::object();
    case 8:
      return Json::array({1, 2, 3});
    case 9:
      return random.pick({5120, 5121, 5122, 5123, 5124, 5125, 5126});
    default:
      return random.below(9);
  }
}

// Swaps, doubles or drops a child.
void shake(Json& value, Random& random) {
  if (value.empty()) return;
  const uint32_t at = random.below(static_cast<uint32_t>(value.size()));
  if (value.is_object()) {
    const auto child = std::next(value.begin(), at);
    if (random.one_in(2))
      value.erase(child);
    else
      value[random.pick({"mesh", "children", "skin", "extensions", "sparse", "byteStride", "matrix", "targets"})] =
          Json(child.value());
    return;
  }
  if (random.one_in(2))
    value.erase(at);
  else
    value.push_back(Json(value[at]));
}

}  // namespace

Json whole_document(Random& random) {
  return Document(random).make();
}

int64_t wrapping_sum(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) + static_cast<uint64_t>(b));
}

void break_document(Json& document, Random& random) {
  const uint32_t breaks = 1 + random.below(4);
  for (uint32_t i = 0; i < breaks; ++i) {
    std::vector<Json*> all;
    collect(document, all);
    Json& value = *all[random.below(static_cast<uint32_t>(all.size()))];
    if (value.is_structured() && random.one_in(2))
      shake(value, random);
    else if (value.is_number_integer() && random.one_in(2))
      value = wrapping_sum(value.get<int64_t>(), random.pick({-1, 1, 7, 1000000, -1000}));
    else
      value = odd_value(random);
  }
}

}  // namespace sideray::fuzz
