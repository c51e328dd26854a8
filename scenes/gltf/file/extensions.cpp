#include "scenes/gltf/file/extensions.h"

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "scenes/base/files.h"

namespace sideray::scenes::gltf {
namespace {

using Json = nlohmann::json;

// Returns null for an unknown extension, else its note, which says what is shown instead if we do not support it.
const char* const* note_of(const std::string& extension) {
  static const std::map<std::string, const char*> known{{"EXT_mesh_gpu_instancing", nullptr},
                                                        {"EXT_meshopt_compression", nullptr},
                                                        {"EXT_texture_webp", nullptr},
                                                        {"KHR_animation_pointer", nullptr},
                                                        {"KHR_draco_mesh_compression", nullptr},
                                                        {"KHR_lights_punctual", nullptr},
                                                        {"KHR_materials_anisotropy", nullptr},
                                                        {"KHR_materials_clearcoat", nullptr},
                                                        {"KHR_materials_diffuse_transmission", nullptr},
                                                        {"KHR_materials_dispersion", nullptr},
                                                        {"KHR_materials_emissive_strength", nullptr},
                                                        {"KHR_materials_ior", nullptr},
                                                        {"KHR_materials_iridescence", nullptr},
                                                        {"KHR_materials_pbrSpecularGlossiness", nullptr},
                                                        {"KHR_materials_sheen", nullptr},
                                                        {"KHR_materials_specular", nullptr},
                                                        {"KHR_materials_transmission", nullptr},
                                                        {"KHR_materials_unlit", nullptr},
                                                        {"KHR_materials_variants", nullptr},
                                                        {"KHR_materials_volume", nullptr},
                                                        {"KHR_materials_volume_scatter", nullptr},
                                                        {"KHR_mesh_quantization", nullptr},
                                                        {"KHR_node_visibility", nullptr},
                                                        {"KHR_texture_basisu", nullptr},
                                                        {"KHR_texture_transform", nullptr},
                                                        {"MSFT_lod", "the most detailed level is shown"}};
  const auto found = known.find(extension);
  return found == known.end() ? nullptr : &found->second;
}

const char* remedy_for(const std::string& extension) {
  static const std::set<std::string> compressed{"KHR_meshopt_compression", "EXT_texture_avif"};
  return compressed.contains(extension) ? "use a decoded copy, for example one that gltf-transform wrote without it"
                                        : "export the scene without it";
}

}  // namespace

void check_extensions(const Json& root, const std::string& path, Warnings& warnings) {
  std::set<std::string> required;
  for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
    const auto list = root.find(key);
    if (list == root.end()) continue;
    if (!list->is_array()) refuse("cannot read {}: {} is not a list; export it again", path, key);
    for (const Json& entry : *list) {
      if (!entry.is_string()) refuse("cannot read {}: {} holds something not a string; export it again", path, key);
      const std::string name = entry.get<std::string>();
      if (const char* const* note = note_of(name)) {
        const bool is_first = key == std::string("extensionsUsed");
        if (*note != nullptr && is_first) warnings.push_back(fmt::format("extension {}: {}", name, *note));
        continue;
      }
      if (key == std::string("extensionsRequired")) {
        refuse("cannot read {}: it requires the extension {}, which is not read; {}", path, name, remedy_for(name));
      }
      warnings.push_back(fmt::format("extension {} is not read; the scene is shown without it", name));
    }
  }
}

}  // namespace sideray::scenes::gltf
