#include <algorithm>

#include "scenes/gltf/gltf.h"

// Applies KHR_materials_variants: other materials for primitives.
namespace sideray::scenes::gltf {
namespace {

constexpr const char* extension_name = "KHR_materials_variants";

// Returns the list `key` of an extension's object, whose entries must be objects.
const tinygltf::Value::Array& list_of(const File& file, const tinygltf::Value& e, const char* key,
                                      const std::string& user) {
  static const tinygltf::Value::Array none;
  if (!e.Has(key)) return none;
  const tinygltf::Value& list = e.Get(key);
  const bool is_list = list.IsArray();
  if (is_list) {
    const auto& entries = list.Get<tinygltf::Value::Array>();
    if (std::all_of(entries.begin(), entries.end(), [](const tinygltf::Value& entry) { return entry.IsObject(); }))
      return entries;
  }
  refuse("cannot read {}: {} of {} is not a list of objects; export it again", file.path, key, user);
}

std::vector<std::string> names_in(const File& file) {
  std::vector<std::string> names;
  const tinygltf::Value* e = extension(file.model.extensions, extension_name);
  if (e == nullptr) return names;
  for (const tinygltf::Value& variant : list_of(file, *e, "variants", extension_name)) {
    const bool is_named = variant.Has("name") && variant.Get("name").IsString();
    names.push_back(is_named ? variant.Get("name").Get<std::string>() : "");
    if (names.back().empty()) names.back() = fmt::format("variant{}", names.size() - 1);
  }
  return names;
}

// Returns whether the mapping lists the wanted variant. Throws Error where it lists one that does not exist.
bool is_for(const File& file, const tinygltf::Value& mapping, size_t wanted, size_t count, const std::string& user) {
  if (!mapping.Has("variants") || !mapping.Get("variants").IsArray())
    refuse("cannot read {}: a mapping of {} lists no variants; export it again", file.path, user);
  const auto& variants = mapping.Get("variants").Get<tinygltf::Value::Array>();
  return std::count_if(variants.begin(), variants.end(), [&](const tinygltf::Value& variant) {
           const int index = variant.IsInt() ? variant.Get<int>() : -1;
           return checked_index(file, index, count, "variant", user) == wanted;
         }) > 0;
}

// Sets the primitive's material to that of the wanted variant; of several, in a broken file, the first counts.
void apply(const File& file, size_t wanted, size_t count, const std::string& user, tinygltf::Primitive& primitive) {
  const tinygltf::Value* e = extension(primitive.extensions, extension_name);
  if (e == nullptr) return;
  for (const tinygltf::Value& mapping : list_of(file, *e, "mappings", user)) {
    if (!is_for(file, mapping, wanted, count, user)) continue;
    const bool has_material = mapping.Has("material") && mapping.Get("material").IsInt();
    const int material = has_material ? mapping.Get("material").Get<int>() : -1;
    primitive.material = static_cast<int>(checked_index(file, material, file.model.materials.size(), "material", user));
    return;
  }
}

}  // namespace

void apply_variant(File& file, const std::string& wanted, Content& content) {
  content.variants = names_in(file);
  check_variant(content, wanted);
  if (wanted.empty()) return;
  const std::vector<std::string>& names = content.variants;
  const auto index = static_cast<size_t>(std::find(names.begin(), names.end(), wanted) - names.begin());
  for (size_t m = 0; m < file.model.meshes.size(); ++m) {
    tinygltf::Mesh& mesh = file.model.meshes[m];
    const std::string user =
        fmt::format("{} of mesh {}", extension_name, mesh.name.empty() ? std::to_string(m) : mesh.name);
    for (tinygltf::Primitive& primitive : mesh.primitives) apply(file, index, names.size(), user, primitive);
  }
}

}  // namespace sideray::scenes::gltf
