#include "scenes/glb/glb_document.h"

#include <bit>

#include "scenes/base/files.h"
#include "scenes/base/limits.h"

namespace sideray::scenes {

static_assert(std::endian::native == std::endian::little,
              "glTF buffers are little-endian; values are copied as they are");

size_t GlbDocument::add_view(const void* data, size_t size) {
  binary_.resize((binary_.size() + 3) / 4 * 4, 0);
  const size_t offset = binary_.size();
  const auto* from = static_cast<const uint8_t*>(data);
  binary_.insert(binary_.end(), from, from + size);
  root_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
  return root_["bufferViews"].size() - 1;
}

size_t GlbDocument::add_accessor(const void* data, size_t count, size_t components, ComponentType type) {
  static constexpr const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  const size_t view = add_view(data, count * components * (type == type_ushort ? 2 : 4));
  root_["accessors"].push_back({{"bufferView", view},
                                {"componentType", static_cast<int>(type)},
                                {"count", count},
                                {"type", components == 16 ? "MAT4" : types[components]}});
  return root_["accessors"].size() - 1;
}

void GlbDocument::add_attribute(Json& attributes, const char* name, const std::vector<float>& values,
                                size_t components) {
  if (values.empty()) return;
  attributes[name] = add_accessor(values.data(), values.size() / components, components, type_float);
}

GlbDocument::Json& GlbDocument::extension(Json& object, const char* name) {
  extensions_.insert(name);
  Json& extension = object["extensions"][name];
  if (extension.is_null()) extension = Json::object();
  return extension;
}

void GlbDocument::finish() {
  if (!extensions_.empty()) root_["extensionsUsed"] = extensions_;
  if (!binary_.empty()) root_["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
}

std::vector<uint8_t> GlbDocument::bytes(const std::string& path) {
  std::string json = root_.dump(-1, ' ', false, Json::error_handler_t::replace);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary_.resize((binary_.size() + 3) / 4 * 4, 0);
  const size_t total = 12 + 8 + json.size() + (binary_.empty() ? 0 : 8 + binary_.size());
  if (total > limits::scene_file_bytes) {
    refuse("cannot write {}: it would have {} bytes, and {} are the most that is read; make the scene smaller", path,
           total, limits::scene_file_bytes);
  }
  std::vector<uint8_t> file;
  file.reserve(total);
  const auto word = [&](size_t value) {
    for (int shift = 0; shift < 32; shift += 8) file.push_back(static_cast<uint8_t>(value >> shift & 0xff));
  };
  word(0x46546c67), word(2), word(total);
  word(json.size()), word(0x4e4f534a);
  file.insert(file.end(), json.begin(), json.end());
  if (binary_.empty()) return file;
  word(binary_.size()), word(0x004e4942);
  file.insert(file.end(), binary_.begin(), binary_.end());
  return file;
}

}  // namespace sideray::scenes
