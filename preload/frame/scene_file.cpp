#include "preload/frame/scene_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "preload/base/png.h"

namespace sideray::run {
namespace {

void append_word(std::string& bytes, size_t value) {
  const auto word = static_cast<uint32_t>(value);
  bytes.append(reinterpret_cast<const char*>(&word), sizeof(word));
}

void pad(std::string& bytes, char with) {
  while (bytes.size() % 4 != 0) bytes += with;
}

bool is_affine(const Matrix& m) {
  return m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1;
}

}  // namespace

SceneFile::SceneFile() {
  root_["asset"] = {{"version", "2.0"}, {"generator", "sideray run"}};
  root_["extensionsUsed"] = {"KHR_materials_unlit"};
  root_["scene"] = 0;
  root_["scenes"][0]["nodes"] = nlohmann::ordered_json::array();
  for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews"}) root_[list] = nlohmann::ordered_json::array();
}

int SceneFile::append(const void* data, size_t size) {
  pad(bytes_, '\0');
  root_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}});
  bytes_.append(static_cast<const char*>(data), size);
  return static_cast<int>(root_["bufferViews"].size()) - 1;
}

int SceneFile::accessor(int view, int type, size_t count, const char* shape) {
  root_["accessors"].push_back({{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", shape}});
  return static_cast<int>(root_["accessors"].size()) - 1;
}

int SceneFile::attribute(const Geometry& geometry, int components, const float* (*of)(const Vertex&)) {
  std::vector<float> values;
  for (const Vertex& vertex : geometry.vertices) values.insert(values.end(), of(vertex), of(vertex) + components);
  for (float& value : values)
    if (!std::isfinite(value)) value = 0;
  const char* shapes[] = {"", "", "VEC2", "VEC3", "VEC4"};
  return accessor(append(values.data(), values.size() * sizeof(float)), GL_FLOAT, geometry.vertices.size(), shapes[components]);
}

int SceneFile::texture(const Texture& texture) {
  if (texture.hash == 0 || texture.texels.empty()) return -1;
  const auto [at, is_new] = textures_.try_emplace(texture.hash, static_cast<int>(textures_.size()));
  if (!is_new) return at->second;
  const std::string file = png(texture.width, texture.height, 4, texture.texels);
  root_["images"].push_back({{"bufferView", append(file.data(), file.size())}, {"mimeType", "image/png"}});
  root_["textures"].push_back({{"source", at->second}});
  return at->second;
}

int SceneFile::material(const DrawState& state, const Texture& first, bool reflects) {
  nlohmann::ordered_json material;
  material["doubleSided"] = true;
  material["pbrMetallicRoughness"] = {{"metallicFactor", 0}, {"roughnessFactor", reflects ? 0 : 1}};
  nlohmann::ordered_json& look = material["pbrMetallicRoughness"];
  if (!state.shows_colors()) {
    const float* c = state.material.diffuse;
    look["baseColorFactor"] = {std::clamp(c[0], 0.f, 1.f), std::clamp(c[1], 0.f, 1.f), std::clamp(c[2], 0.f, 1.f), std::clamp(c[3], 0.f, 1.f)};
  }
  if (const int index = texture(first); index >= 0) look["baseColorTexture"] = {{"index", index}};
  if (reflects) material["alphaMode"] = "BLEND";
  if (!reflects && state.alpha_test) material["alphaMode"] = "MASK", material["alphaCutoff"] = state.alpha_reference;
  if (!state.lighting && !reflects) material["extensions"]["KHR_materials_unlit"] = nlohmann::ordered_json::object();
  root_["materials"].push_back(material);
  return static_cast<int>(root_["materials"].size()) - 1;
}

void SceneFile::add(const Geometry& geometry, const DrawState& state, const Texture& first, bool reflects) {
  const std::vector<uint32_t> triangles = triangles_of(geometry);
  if (triangles.empty() || !is_affine(state.modelview)) return;
  nlohmann::ordered_json primitive;
  const int positions = attribute(geometry, 3, [](const Vertex& v) { return v.position; });
  for (const char* which : {"min", "max"}) {
    nlohmann::ordered_json& bound = root_["accessors"][static_cast<size_t>(positions)][which];
    for (size_t c = 0; c < 3; ++c) {
      float value = geometry.vertices[0].position[c];
      for (const Vertex& v : geometry.vertices) value = which[1] == 'i' ? std::min(value, v.position[c]) : std::max(value, v.position[c]);
      bound.push_back(value);
    }
  }
  primitive["attributes"]["POSITION"] = positions;
  primitive["attributes"]["TEXCOORD_0"] = attribute(geometry, 2, [](const Vertex& v) -> const float* { return v.uv[0]; });
  if (state.shows_colors()) primitive["attributes"]["COLOR_0"] = attribute(geometry, 4, [](const Vertex& v) -> const float* { return v.color; });
  primitive["indices"] = accessor(append(triangles.data(), triangles.size() * sizeof(uint32_t)), GL_UNSIGNED_INT, triangles.size(), "SCALAR");
  primitive["material"] = material(state, first, reflects);
  root_["meshes"].push_back({{"primitives", {primitive}}});
  root_["scenes"][0]["nodes"].push_back(root_["nodes"].size());
  root_["nodes"].push_back({{"mesh", root_["meshes"].size() - 1}, {"matrix", state.modelview}});
}

void SceneFile::set_camera(const Matrix& projection) {
  const double aspect = static_cast<double>(projection[5]) / static_cast<double>(projection[0]);
  root_["cameras"] = {{{"type", "perspective"},
                       {"perspective", {{"yfov", 2 * std::atan(1 / static_cast<double>(projection[5]))}, {"aspectRatio", aspect}, {"znear", 0.1}}}}};
  root_["scenes"][0]["nodes"].push_back(root_["nodes"].size());
  root_["nodes"].push_back({{"camera", 0}});
}

bool SceneFile::write(const std::string& path) {
  pad(bytes_, '\0');
  root_["buffers"] = {{{"byteLength", bytes_.size()}}};
  std::string text = root_.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace), file = "glTF";
  pad(text, ' ');
  append_word(file, 2);
  append_word(file, 28 + text.size() + bytes_.size());
  append_word(file, text.size());
  file += "JSON" + text;
  append_word(file, bytes_.size());
  file += std::string("BIN\0", 4) + bytes_;
  std::ofstream out(path, std::ios::binary);
  out << file;
  out.close();
  return static_cast<bool>(out);
}

}  // namespace sideray::run
